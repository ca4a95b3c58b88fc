// How far an axis turns on after a limit switch has closed.
#pragma once

#include <cstdint>

#include "firmware/core/config/axis_settings.hpp"
#include "firmware/core/config/design_parameters.hpp"
#include "firmware/core/integer/wide.hpp"

namespace umov::firmware {

/// From full speed v to rest along the axis' own ramp, v²/2a + va/2j, or v √(v/j) where the
/// acceleration a is not reached; and before that v for `stop_delay_us`, in which the stop is
/// noticed and planned; and a step, in which the switch is seen. Microdegrees, rounded up. What is
/// beyond a limit switch must leave an axis so much room.
constexpr std::uint64_t stopping_distance_udeg(const AxisSettings& axis) {
  const std::uint64_t v = axis.speed_mdeg_s, a = axis.acceleration_mdeg_s2, j = axis.jerk_mdeg_s3;
  const auto share = [](std::uint64_t of, std::uint64_t by) { return (of + by - 1) / by; };
  const std::uint64_t delay = share(v * stop_delay_us, 1000);
  const std::uint64_t step = share(360'000'000, axis.steps_per_turn);
  if (multiply(v, j) >= multiply(a, a)) {
    return share(1000 * v * v, 2 * a) + divide_up(multiply(1000 * v, a), 2 * j).low + delay + step;
  }
  const std::uint64_t ramp_us = square_root_up(divide_up(multiply(v, 1'000'000'000'000), j));
  return share(v * ramp_us, 1000) + delay + step;
}

}  // namespace umov::firmware
