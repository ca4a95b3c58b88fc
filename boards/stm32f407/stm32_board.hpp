// The board as the core sees it: pins, step timers, sampling and link put together.
#pragma once

#include "boards/stm32f407/reference_input.hpp"
#include "boards/stm32f407/sampling.hpp"
#include "boards/stm32f407/step_outputs.hpp"
#include "boards/stm32f407/uart_link.hpp"
#include "firmware/core/port.hpp"
#include "firmware/core/usb/device.hpp"

namespace umov::boards::stm32f407 {

class Stm32Board final : public firmware::Board {
 public:
  /// Once, when the clocks run: everything dark and at rest.
  void set_up();

  std::uint64_t time_us() const override;
  std::uint64_t link_time_us() const override { return time_us(); }
  std::size_t link_room() const override { return usb_->link_room(); }
  bool write_link(std::span<const std::uint8_t> frame) override { return usb_->write_link(frame); }

  void set_direction(int axis, int direction) override;
  void start_step_timer(int axis, std::uint32_t ticks) override { steps_.start(axis, ticks); }
  void stop_step_timer(int axis) override { steps_.stop(axis); }
  /// The compare channel has raised the pin already.
  void step(int) override {}
  firmware::AxisInputs switches(int axis) const override;

  void set_laser(int laser, bool on) override;
  void set_shutter(bool open) override;
  void set_gain(int range) override;
  bool interlock_closed() const override;
  bool emergency_released() const override;
  bool overheated() const override;
  bool supply_low() const override;
  bool stalled(int axis) const override;

  std::uint32_t start_sampling(std::uint32_t phase_step) override {
    return sampling_.start(phase_step);
  }
  std::uint32_t reference_clock() const override { return reference_tick(tim1().CNT); }
  void stop_sampling() override { sampling_.stop(); }

  void mask_interrupts() override;
  void unmask_interrupts() override;

  /// The link of all hosts, on USB and on the serial line.
  void use_link(firmware::usb::Device& usb) { usb_ = &usb; }

  StepOutputs& steps() { return steps_; }
  Sampling& sampling() { return sampling_; }
  ReferenceInput& reference() { return reference_; }
  UartLink& serial() { return serial_; }

 private:
  StepOutputs steps_;
  Sampling sampling_;
  ReferenceInput reference_;
  UartLink serial_;
  firmware::usb::Device* usb_ = nullptr;
  mutable std::uint32_t clock_low_ = 0;
  mutable std::uint32_t clock_high_ = 0;
};

}  // namespace umov::boards::stm32f407
