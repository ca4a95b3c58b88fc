// Where on its way a limit switch costs an axis the most.
#pragma once

#include <cstdint>

#include "firmware/core/config/axis_settings.hpp"
#include "firmware/core/config/design_parameters.hpp"
#include "firmware/core/motion/profile.hpp"

namespace umov::test {

/// Step at which a move of `steps` from zero begins to accelerate less: an axis that is stopped
/// there gains the most speed yet.
inline std::int32_t acceleration_end(const firmware::AxisSettings& axis, std::uint32_t steps) {
  const firmware::Profile move(
      steps,
      firmware::motion_limits(axis.steps_per_turn, axis.speed_mdeg_s, axis.acceleration_mdeg_s2,
                              axis.jerk_mdeg_s3),
      firmware::step_timer_hz);
  const firmware::SegmentTicks& d = move.durations();
  return static_cast<std::int32_t>(move.distance_at(d.jerk + d.acceleration) >>
                                   firmware::Profile::fraction_bits);
}

}  // namespace umov::test
