// The program: start-up order, main loop, and which interrupt calls what.
#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <new>
#include <string_view>

#include "boards/stm32f407/boot_flash.hpp"
#include "boards/stm32f407/chip_serial.hpp"
#include "boards/stm32f407/clock.hpp"
#include "boards/stm32f407/flash_log.hpp"
#include "boards/stm32f407/registers/core.hpp"
#include "boards/stm32f407/registers/gpio.hpp"
#include "boards/stm32f407/reset_cause.hpp"
#include "boards/stm32f407/settings_flash.hpp"
#include "boards/stm32f407/stm32_board.hpp"
#include "boards/stm32f407/usb_application.hpp"
#include "boards/stm32f407/usb_port.hpp"
#include "boards/stm32f407/watchdog.hpp"
#include "firmware/boot/notes.hpp"
#include "firmware/boot/trial.hpp"
#include "firmware/core/controller.hpp"
#include "firmware/source_hash.hpp"
#include "protocol/boot_note.hpp"

namespace umov::boards::stm32f407 {
namespace {

Stm32Board board;
FlashLog fault_log;
SettingsFlash settings_flash;
firmware::SettingsPages settings(settings_flash);
BootFlash image_places;
firmware::boot::Trial trial(image_places);
bool on_trial = false;
alignas(firmware::Controller) std::byte controller_place[sizeof(firmware::Controller)];
firmware::Controller* controller = nullptr;
UsbPort usb_port;
UsbApplication usb_application;
alignas(firmware::usb::Device) std::byte usb_place[sizeof(firmware::usb::Device)];
firmware::usb::Device* usb = nullptr;
std::atomic<bool> tick_due{false};

/// Priorities, 0 the most urgent: step edges first, then what must go dark at once and edges of the
/// reference, samples, link.
void start_interrupts() {
  set_priority(Irq::tim2, 0);
  set_priority(Irq::tim5, 0);
  set_priority(Irq::exti4, 1);
  set_priority(Irq::exti9_5, 1);
  set_priority(Irq::exti15_10, 1);
  set_priority(Irq::pvd, 1);
  set_priority(Irq::adc, 1);
  set_priority(Irq::tim1_cc, 1);
  set_priority(Irq::dma2_stream0, 2);
  set_priority(Irq::dma1_stream6, 3);
  set_priority(Irq::otg_fs, 3);
  set_systick_priority(3);
  for (const Irq irq :
       {Irq::tim2, Irq::tim5, Irq::exti4, Irq::exti9_5, Irq::exti15_10, Irq::pvd, Irq::adc,
        Irq::tim1_cc, Irq::dma2_stream0, Irq::dma1_stream6, Irq::otg_fs}) {
    enable(irq);
  }
  systick().RVR = core_hz / 1000 - 1;
  systick().CVR = 0;
  systick().CSR = systick_bits::ENABLE | systick_bits::TICKINT | systick_bits::CLKSOURCE;
}

firmware::Identity identity(const ResetReport& reset, std::uint32_t boot_id) {
  firmware::Identity who{.firmware_hash = firmware::source_hash,
                         .boot_id = boot_id,
                         .reset_cause = reset.cause,
                         .reset_detail = reset.program_counter};
  constexpr std::string_view name = board_name;
  static_assert(name.size() <= sizeof(who.device_name));
  std::copy(name.begin(), name.end(), who.device_name.begin());
  who.serial = chip_serial();
  return who;
}

void stalled(std::uint32_t lines) {
  for (int axis = 0; axis < static_cast<int>(axis_pins.size()); ++axis) {
    if ((axis_pins[static_cast<std::size_t>(axis)].stall.mask() & lines) != 0) {
      controller->on_stall(axis);
    }
  }
}

std::uint32_t take_lines(std::uint32_t lines) {
  const std::uint32_t pending = exti().PR & lines;
  exti().PR = pending;
  return pending;
}

/// An edge counts even when the line is good again: the light was out for that moment.
void safety_inputs_changed(std::uint32_t lines) {
  if ((lines & interlock_pin.mask()) != 0) controller->on_interlock_open();
  if ((lines & emergency_pin.mask()) != 0) controller->on_emergency_stop();
  if ((lines & cool_pin.mask()) != 0) controller->on_overheat();
}

template <unsigned timer>
void on_step_timer() {
  board.steps().on_interrupt<timer>([](int axis) { return controller->on_step_timer(axis); },
                                    [](int axis) { controller->on_late_step(axis); });
}

/// What the boot loader has done becomes faults, and they are in the log before it forgets them.
/// With a low supply nothing is written: the next start tells them again.
void tell_boot_notes() {
  firmware::boot::Notes notes(image_places);
  while (const auto note = notes.next()) {
    controller->on_boot_note(note->fault, note->detail);
    if (board.supply_low()) return;
    fault_log.service();
    if (!notes.mark_told()) return;
  }
}

/// The image proves itself when a host has had answers from it, by which it can be replaced again,
/// and its main loop has gone round for ten seconds. An image that merely runs, and that nobody can
/// reach, is no better than one that hangs. Where flash does not take the note, the image stays on
/// trial: that is a fault, once a start.
void end_trial() {
  constexpr std::uint64_t long_enough_us = 10'000'000;
  if (!on_trial || !controller->host_answered() || board.time_us() < long_enough_us) return;
  on_trial = false;
  if (trial.confirm()) return;
  controller->on_boot_note(protocol::Fault::internal, protocol::trial_not_confirmed);
}

}  // namespace
}  // namespace umov::boards::stm32f407

using namespace umov::boards::stm32f407;

extern "C" {

void tim1_cc_handler() {
  board.reference().on_interrupt([](std::uint32_t tick) { controller->on_reference_edge(tick); });
}
void tim2_handler() {
  on_step_timer<2>();
}
void tim5_handler() {
  on_step_timer<5>();
}
void exti4_handler() {
  stalled(take_lines(bit(4)));
}
void exti9_5_handler() {
  stalled(take_lines(0x3E0));
}
void exti15_10_handler() {
  safety_inputs_changed(take_lines(0xFC00));
}
void pvd_handler() {
  if (take_lines(supply_line) != 0) controller->on_low_supply();
}
void adc_handler() {
  if (board.sampling().take_overrun()) controller->on_adc_overrun();
}
void dma2_stream0_handler() {
  const bool all = board.sampling().on_interrupt(
      [](std::span<const std::uint16_t> signal, std::span<const std::uint16_t> monitor) {
        controller->on_samples(signal, monitor);
      });
  if (all) return;
  board.sampling().stop();
  controller->on_adc_overrun();
}
void dma1_stream6_handler() {
  board.serial().on_sent();
}
void otg_fs_handler() {
  usb_port.on_interrupt();
}
void systick_handler() {
  tick_due.store(true, std::memory_order_release);
}

int main() {
  start_clocks();
  const ResetReport reset = take_reset_cause();
  board.set_up();
  const std::uint32_t boot_id = fault_log.begin();
  settings.begin();
  controller = new (controller_place)
      umov::firmware::Controller(board, fault_log, identity(reset, boot_id), axes, &settings);
  usb = new (usb_place)
      umov::firmware::usb::Device(usb_port, usb_application, chip_serial(), &board.serial());
  usb_application.bind(*controller);
  board.use_link(*usb);
  usb_port.set_up();
  controller->start();
  tell_boot_notes();
  on_trial = trial.open();
  usb->start();
  watch_main_loop();
  start_interrupts();
  for (;;) {
    usb_port.poll(*usb);
    board.serial().read([](std::span<const std::uint8_t> bytes) { usb->take_serial(bytes); });
    if (tick_due.exchange(false, std::memory_order_acquire)) {
      feed_watchdog();
      board.serial().service();
      board.reference().service();
      controller->tick();
      usb->tick(board.time_us());
      if (!controller->motion().busy() && !board.supply_low()) {
        fault_log.service();
        end_trial();
      }
      if (usb_application.detached()) {
        usb_port.disconnect();
        reset_with(BootRequest::update);
      }
    }
    if (controller->send_more()) continue;
    // An interrupt between the look at the flag and here only costs the rest of this millisecond's
    // sleep if it was not the tick; a tick is looked for with interrupts held off.
    const CriticalSection alone;
    if (!tick_due.load(std::memory_order_relaxed)) asm volatile("wfi");
  }
}
}
