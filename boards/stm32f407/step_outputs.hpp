// Step pulses of six axes: two 32-bit timers run freely at the core's step clock, a compare channel
// raises an axis' pin on the very tick, the interrupt lowers it and sets the next.
#pragma once

#include <array>
#include <cstdint>

#include "boards/stm32f407/board_description.hpp"
#include "boards/stm32f407/registers/timer.hpp"
#include "firmware/core/config/design_parameters.hpp"

namespace umov::boards::stm32f407 {

/// Contexts: on_interrupt() in the timers' interrupts (one priority for both), the rest in the main
/// loop. An edge that falls due while interrupts are late is raised late, never dropped: the edges
/// after it keep to their own ticks.
class StepOutputs {
 public:
  void set_up();
  /// First edge `ticks` from now.
  void start(int axis, std::uint32_t ticks);
  /// No further edge. One that has been raised already is still counted: its interrupt follows.
  void stop(int axis);

  /// Interrupt of TIM2 or TIM5: for each edge raised calls `on_step(axis)`, which returns the ticks
  /// to the next or 0.
  template <class OnStep>
  void on_interrupt(unsigned timer, OnStep&& on_step) {
    for (int axis = 0; axis < static_cast<int>(axis_pins.size()); ++axis) {
      if (axis_pins[index(axis)].timer != timer || !raised(axis)) continue;
      const std::uint32_t due = take(axis);
      const std::uint32_t interval = on_step(axis);
      end_pulse(axis);
      if (interval == 0 || ending_[index(axis)]) {
        disarm(axis);
      } else {
        arm(axis, due + interval);
      }
    }
  }

 private:
  static std::size_t index(int axis) { return static_cast<std::size_t>(axis); }
  bool raised(int axis) const;
  std::uint32_t take(int axis);
  void end_pulse(int axis);
  void arm(int axis, std::uint32_t due);
  void disarm(int axis);

  std::array<std::uint32_t, 6> raised_at_{};
  std::array<volatile bool, 6> ending_{};
};

/// Ticks of the step clock since start, modulo 2^32; the device's time base.
std::uint32_t step_clock();

}  // namespace umov::boards::stm32f407
