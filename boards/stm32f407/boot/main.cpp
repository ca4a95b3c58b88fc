// The boot loader: ends updates, starts the program if it is good, else takes another one over USB.
#include <new>

#include "boards/stm32f407/board_description.hpp"
#include "boards/stm32f407/boot_flash.hpp"
#include "boards/stm32f407/boot_request.hpp"
#include "boards/stm32f407/chip_serial.hpp"
#include "boards/stm32f407/clock.hpp"
#include "boards/stm32f407/registers/rcc.hpp"
#include "boards/stm32f407/registers/timer.hpp"
#include "boards/stm32f407/step_outputs.hpp"
#include "boards/stm32f407/usb_port.hpp"
#include "boards/stm32f407/watchdog.hpp"
#include "firmware/boot/boot_device.hpp"
#include "firmware/boot/signing_key.hpp"
#include "firmware/boot/start.hpp"

namespace umov::boards::stm32f407 {

/// The USB driver waits by it. It runs freely at the same rate as in the program.
std::uint32_t step_clock() {
  return tim5().CNT;
}

namespace {

using firmware::boot::Reason;
using firmware::boot::Restart;
using firmware::boot::Start;

BootFlash flash;
UsbPort usb_port;
alignas(firmware::boot::BootDevice) std::byte device_place[sizeof(firmware::boot::BootDevice)];

constexpr firmware::boot::Trust trust = {board_name, firmware::boot::signing_key};

void start_clock_of_usb() {
  using namespace timer_bits;
  tim5().CR1 = URS;
  tim5().PSC = apb1_timer_hz / firmware::step_timer_hz - 1;
  tim5().ARR = 0xFFFF'FFFF;
  tim5().EGR = UG;
  tim5().CR1 = URS | CEN;
}

/// Every reset pulls the reset line, too: it was the cause where nothing else was. A request may
/// outlive a sag of the supply.
Restart why_restarted(BootRequest request, std::uint32_t flags) {
  using namespace rcc_bits;
  if ((flags & (PORRSTF | BORRSTF)) != 0) return Restart::power;
  if (request != BootRequest::none) return Restart::asked;
  if ((flags & IWDGRSTF) != 0) return Restart::watchdog;
  if ((flags & SFTRSTF) != 0) return Restart::crash;
  return Restart::button;
}

Reason why_here(Start start) {
  switch (start) {
    case Start::no_image:
      return Reason::empty;
    case Start::failed_trial:
      return Reason::failed_trial;
    case Start::flash_fails:
      return Reason::worn_out;
    case Start::program:
      break;
  }
  return Reason::none;
}

/// The program finds the chip as after a reset, but for its memory: on the internal oscillator,
/// with the blocks it is going to switch on still off. Only the watchdog runs, for a program that
/// hangs before it has started its own. From here on a reset is the program's.
[[noreturn]] void start_program() {
  stop_clocks();
  leave_boot_request(BootRequest::none);
  watch_start();
  const auto* vectors = reinterpret_cast<const volatile std::uint32_t*>(
      image_area.address + protocol::ImageHeader::bytes);
  const std::uint32_t stack_top = vectors[0], entry = vectors[1];
  asm volatile("msr msp, %0\n\tbx %1" : : "r"(stack_top), "r"(entry) : "memory");
  __builtin_unreachable();
}

[[noreturn]] void take_updates(Reason why) {
  start_clock_of_usb();
  usb_port.set_up();
  auto* device = new (device_place) firmware::boot::BootDevice(
      usb_port, flash, trust, chip_serial(), firmware::boot::development_key, why);
  device->start();
  // The USB interrupt is never taken: pending, it ends the sleep.
  asm volatile("cpsid i" : : : "memory");
  enable(Irq::otg_fs);
  while (!device->leaving()) {
    clear_pending(Irq::otg_fs);
    usb_port.poll(*device);
    device->work();
    if (!device->working() && !device->leaving()) asm volatile("wfi");
  }
  usb_port.disconnect();
  reset_with(BootRequest::started);
}

}  // namespace
}  // namespace umov::boards::stm32f407

int main() {
  using namespace umov::boards::stm32f407;
  const BootRequest request = take_boot_request();
  // A reset from here on, by the button for one, says nothing of an image that has not run.
  leave_boot_request(BootRequest::started);
  const std::uint32_t flags = rcc().CSR;
  set_bits(rcc().CSR, rcc_bits::RMVF);
  const Restart why = why_restarted(request, flags);
  start_clocks();
  if (request == BootRequest::update) {
    umov::firmware::boot::end_update(flash, trust);
    take_updates(Reason::none);
  }
  const auto decision = umov::firmware::boot::make_runnable(flash, trust, why);
  if (decision.start != Start::program) take_updates(why_here(decision.start));
  // A reset that boot loader and program agreed upon is no news to the program, nor is one that
  // another image is to blame for.
  const bool no_news = why == Restart::asked || decision.rolled_back;
  hand_over_reset_flags(no_news ? 0 : flags);
  start_program();
}
