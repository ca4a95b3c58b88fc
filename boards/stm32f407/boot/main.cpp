// The boot loader: ends updates, starts the program if it is good, else takes another one over USB.
#include <new>

#include "boards/stm32f407/board_description.hpp"
#include "boards/stm32f407/boot/boot_flash.hpp"
#include "boards/stm32f407/boot_request.hpp"
#include "boards/stm32f407/chip_serial.hpp"
#include "boards/stm32f407/clock.hpp"
#include "boards/stm32f407/registers/rcc.hpp"
#include "boards/stm32f407/registers/timer.hpp"
#include "boards/stm32f407/step_outputs.hpp"
#include "boards/stm32f407/usb_port.hpp"
#include "firmware/boot/boot_device.hpp"
#include "firmware/boot/signing_key.hpp"
#include "firmware/boot/start.hpp"

namespace umov::boards::stm32f407 {

/// The USB driver waits by it. It runs freely at the same rate as in the program.
std::uint32_t step_clock() {
  return tim5().CNT;
}

namespace {

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

/// The program finds the chip as after a reset, but for its memory: on the internal oscillator,
/// with the blocks it is going to switch on still off.
[[noreturn]] void start_program() {
  stop_clocks();
  const auto* vectors = reinterpret_cast<const volatile std::uint32_t*>(
      image_area.address + protocol::ImageHeader::bytes);
  const std::uint32_t stack_top = vectors[0], entry = vectors[1];
  asm volatile("msr msp, %0\n\tbx %1" : : "r"(stack_top), "r"(entry) : "memory");
  __builtin_unreachable();
}

[[noreturn]] void take_updates() {
  start_clock_of_usb();
  usb_port.set_up();
  auto* device = new (device_place) firmware::boot::BootDevice(
      usb_port, flash, trust, chip_serial(), firmware::boot::development_key);
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
  // A reset that the boot loader and the program agreed upon is no news to the program.
  if (request != BootRequest::none) set_bits(rcc().CSR, rcc_bits::RMVF);
  start_clocks();
  if (request == BootRequest::update) {
    umov::firmware::boot::end_update(flash, trust);
  } else if (umov::firmware::boot::make_runnable(flash, trust)) {
    start_program();
  }
  take_updates();
}
