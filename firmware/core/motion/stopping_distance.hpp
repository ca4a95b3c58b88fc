// How far an axis turns on after a limit switch has closed.
#pragma once

#include <cstdint>

#include "firmware/core/config/axis_settings.hpp"
#include "firmware/core/config/design_parameters.hpp"
#include "firmware/core/integer/wide.hpp"

namespace umov::firmware {

/// The longest way is that of a switch met where the acceleration a is about to fall: the axis goes
/// on to its full speed v meanwhile, since a stop keeps to the jerk j. That takes T = a/j and
/// T (v - aT/6); then follows its own ramp, v²/2a + va/2j. Where a is not reached they are
/// 5/6 v √(v/j) and v √(v/j). Before that v for `stop_delay_us`, in which the stop is noticed and
/// planned; and a step, in which the switch is seen. Microdegrees, rounded up. What is beyond a
/// limit switch must leave an axis so much room.
constexpr std::uint64_t stopping_distance_udeg(const AxisSettings& axis) {
  const std::uint64_t v = axis.speed_mdeg_s, a = axis.acceleration_mdeg_s2, j = axis.jerk_mdeg_s3;
  const auto share = [](std::uint64_t of, std::uint64_t by) { return (of + by - 1) / by; };
  const std::uint64_t before =
      share(v * stop_delay_us, 1000) + share(360'000'000, axis.steps_per_turn);
  if (multiply(v, j) >= multiply(a, a)) {
    const std::uint64_t mean_udeg_s = 1000 * v - divide(multiply(1000 * a, a), 6 * j).low;
    const std::uint64_t rising = divide_up(multiply(mean_udeg_s, a), j).low;
    const std::uint64_t ramp =
        share(1000 * v * v, 2 * a) + divide_up(multiply(1000 * v, a), 2 * j).low;
    return before + rising + ramp;
  }
  const std::uint64_t turn_us = square_root_up(divide_up(multiply(v, 1'000'000'000'000), j));
  return before + share(11 * v * turn_us, 6000);
}

}  // namespace umov::firmware
