// A rotary stage: motor steps in, true angle and switches out.
#pragma once

#include <array>
#include <cstdint>

#include "hil/plant/plant_config.hpp"

namespace umov::plant {

/// How an axis is built; must agree with the board's settings for the commanded angles to be true.
struct AxisTravel {
  std::uint32_t steps_per_turn = 360'000;
  /// Angle of the home switch's edge: pressed everywhere below, released at it and above.
  double home_deg = 0.0;
  double lower_limit_deg = -95.0;  ///< limit switches press at and beyond these angles
  double upper_limit_deg = 95.0;
  double start_deg = 0.0;  ///< where the axis stands when the instrument is switched on
};

/// The reference instrument: steps and soft limits of the reference controller, limit switches 4°
/// beyond.
std::array<AxisTravel, axis_count> reference_travel();

/// Switches of an axis. They sit on the drive, before the play, so that homing sets the motor's
/// zero.
struct AxisSwitches {
  bool home = false;
  bool lower_limit = false;
  bool upper_limit = false;
};

class Stage {
 public:
  /// `seed` decides the standstill offsets.
  Stage(const AxisTravel& travel, const AxisErrors& errors, std::uint64_t seed);

  /// `count` steps, direction +1 or -1, begun at `time_s`. The play is taken up as the motor turns.
  void step(int direction, double time_s = 0.0, std::int64_t count = 1);
  std::int64_t steps() const { return steps_; }
  AxisSwitches switches() const;

  /// Angle that the motor's steps stand for, before any error.
  double motor_deg() const;
  /// Angle at which the optics really stand.
  double true_deg() const;

 private:
  AxisErrors errors_;
  std::uint64_t seed_;
  double home_deg_;
  double degrees_per_step_;
  double half_play_steps_;
  std::int64_t lower_limit_steps_ = 0, upper_limit_steps_ = 0;
  std::int64_t steps_ = 0;      ///< from the home edge
  std::uint64_t moves_ = 0;     ///< steps made in all, either way
  double carried_steps_ = 0.0;  ///< where the play has left the stage
  double windup_ = 0.0;         ///< -1 … 1, in units of the wind-up's amplitude
  bool slipped_ = false;
};

}  // namespace umov::plant
