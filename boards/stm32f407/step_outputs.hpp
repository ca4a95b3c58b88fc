// Step pulses of six axes: two 32-bit timers run freely at the core's step clock, a compare channel
// raises an axis' pin on the very tick, the interrupt lowers it and sets the next.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "boards/stm32f407/board_description.hpp"
#include "boards/stm32f407/pins.hpp"
#include "boards/stm32f407/registers/timer.hpp"
#include "firmware/core/config/design_parameters.hpp"

namespace umov::boards::stm32f407 {

/// Contexts: on_interrupt() in the timers' interrupts (one priority for both), the rest in the main
/// loop. An edge that falls due while interrupts are late is raised late, never dropped, and not
/// before the pin was low for `step_low_us`: the edges after it keep to their own ticks.
class StepOutputs {
 public:
  void set_up();
  /// First edge `ticks` from now.
  void start(int axis, std::uint32_t ticks);
  /// No further edge. One that has been raised already is still counted: its interrupt follows.
  void stop(int axis);

  /// Interrupt of TIM2 or TIM5: for each edge raised calls `on_step(axis)`, which returns the ticks
  /// to the next or 0, and `on_late(axis)` when it came later than `late_step_ticks`. Axis, channel
  /// and addresses are constants of the code made for each.
  template <unsigned timer_number, class OnStep, class OnLate>
  void on_interrupt(OnStep&& on_step, OnLate&& on_late) {
    TimerRegisters& timer = timer_number == 2 ? tim2() : tim5();
    const std::uint32_t raised = timer.SR & timer.DIER;
    bool first = true;
    for_each_axis([&]<std::size_t axis>() {
      if constexpr (axis_pins[axis].timer == timer_number) {
        if ((raised & timer_bits::CC(axis_pins[axis].channel)) == 0) return;
        timer.SR = ~timer_bits::CC(axis_pins[axis].channel);
        if (raised_at_[axis] - due_[axis] > firmware::late_step_ticks)
          on_late(static_cast<int>(axis));
        const std::uint32_t interval = on_step(static_cast<int>(axis));
        // The pulses have lasted while this was worked out. All are ended now: one that waited for
        // its turn would leave too little time for the pin to be low.
        if (first) lower<timer_number>(raised);
        first = false;
        if (interval == 0 || ending_[axis]) {
          disarm<axis>();
        } else {
          arm<axis>(due_[axis] + interval);
        }
      }
    });
  }

 private:
  template <class Each>
  static void for_each_axis(Each&& each) {
    [&]<std::size_t... axis>(std::index_sequence<axis...>) {
      (each.template operator()<axis>(), ...);
    }
    (std::make_index_sequence<axis_pins.size()>{});
  }
  template <std::size_t axis>
  static TimerRegisters& timer_of() {
    return axis_pins[axis].timer == 2 ? tim2() : tim5();
  }
  template <std::size_t axis>
  static void set_mode(std::uint32_t mode) {
    constexpr unsigned place = axis_pins[axis].channel - 1;
    constexpr unsigned shift = 8 * (place % 2) + 4;
    change_bits(timer_of<axis>().CCMR[place / 2], 7u << shift, mode << shift);
  }

  /// Ends the pulses of these channels, each not before its time.
  template <unsigned timer_number>
  void lower(std::uint32_t raised) {
    for_each_axis([&]<std::size_t axis>() {
      if constexpr (axis_pins[axis].timer == timer_number) {
        if ((raised & timer_bits::CC(axis_pins[axis].channel)) == 0) return;
        TimerRegisters& timer = timer_of<axis>();
        while (timer.CNT - raised_at_[axis] < pulse_ticks) {
        }
        set_mode<axis>(timer_bits::OC_FORCE_LOW);
        lowered_at_[axis] = timer.CNT;
      }
    });
  }

  template <std::size_t axis>
  void arm(std::uint32_t due) {
    constexpr unsigned channel = axis_pins[axis].channel;
    TimerRegisters& timer = timer_of<axis>();
    due_[axis] = due;
    const std::uint32_t earliest = lowered_at_[axis] + low_ticks;
    const std::uint32_t edge = static_cast<std::int32_t>(due - earliest) < 0 ? earliest : due;
    raised_at_[axis] = edge;
    timer.CCR[channel - 1] = edge;
    set_mode<axis>(timer_bits::OC_HIGH_ON_MATCH);
    // The tick may have gone by before the channel was ready: then there is no match for 2^32
    // ticks, or one that found the pin held low.
    const std::uint32_t now = timer.CNT;
    if (static_cast<std::int32_t>(now - edge) < 0 || read(axis_pins[axis].step)) return;
    raised_at_[axis] = now;
    set_mode<axis>(timer_bits::OC_FORCE_HIGH);
    timer.EGR = timer_bits::CC(channel);
  }

  template <std::size_t axis>
  static void disarm() {
    constexpr unsigned channel = axis_pins[axis].channel;
    TimerRegisters& timer = timer_of<axis>();
    clear_bits(timer.DIER, timer_bits::CC(channel));
    set_mode<axis>(timer_bits::OC_FORCE_LOW);
    timer.SR = ~timer_bits::CC(channel);
  }

  /// The pin went low somewhere within the tick that was read.
  static constexpr std::uint32_t low_ticks =
      step_low_us * (firmware::step_timer_hz / 1'000'000) + 1;
  static constexpr std::uint32_t pulse_ticks =
      step_pulse_us * (firmware::step_timer_hz / 1'000'000);

  // Ticks of the step clock: when the edge under way is due, was raised, and the last one ended.
  std::array<std::uint32_t, axis_pins.size()> due_{};
  std::array<std::uint32_t, axis_pins.size()> raised_at_{};
  std::array<std::uint32_t, axis_pins.size()> lowered_at_{};
  std::array<volatile bool, axis_pins.size()> ending_{};
};

/// Ticks of the step clock since start, modulo 2^32; the device's time base.
std::uint32_t step_clock();

}  // namespace umov::boards::stm32f407
