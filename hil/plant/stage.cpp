#include "hil/plant/stage.hpp"

#include <algorithm>
#include <cmath>

#include "hil/plant/noise.hpp"
#include "host/optics/angles.hpp"

namespace umov::plant {

std::array<AxisTravel, axis_count> reference_travel() {
  std::array<AxisTravel, axis_count> travel;
  travel[0] = {360'000, 0.0, -14.0, 94.0, 12.0};
  travel[1] = {360'000, 0.0, -94.0, 94.0, 20.0};
  travel[2] = {360'000, 0.0, -184.0, 184.0, 5.0};
  // The parking position `open` lies at 200°.
  travel[3] = {72'000, 0.0, -184.0, 206.0, 30.0};
  travel[4] = {72'000, 0.0, -184.0, 206.0, -15.0};
  travel[5] = {36'000, 0.0, -9.0, 309.0, 60.0};
  return travel;
}

Stage::Stage(const AxisTravel& travel, const AxisErrors& errors, std::uint64_t seed)
    : errors_(errors),
      seed_(seed),
      home_deg_(travel.home_deg),
      degrees_per_step_(360.0 / travel.steps_per_turn),
      half_play_steps_(0.5 * errors.backlash_deg / degrees_per_step_) {
  const auto from_home = [&](double angle_deg) {
    return (angle_deg - home_deg_) / degrees_per_step_;
  };
  // A switch angle that falls on a step presses there, in spite of rounding.
  constexpr double rounding = 1e-6;
  lower_limit_steps_ =
      static_cast<std::int64_t>(std::floor(from_home(travel.lower_limit_deg) + rounding));
  upper_limit_steps_ =
      static_cast<std::int64_t>(std::ceil(from_home(travel.upper_limit_deg) - rounding));
  steps_ = std::llround(from_home(travel.start_deg));
  carried_steps_ = static_cast<double>(steps_);
}

void Stage::step(int direction, double time_s, std::int64_t count) {
  steps_ += direction > 0 ? count : -count;
  moves_ += static_cast<std::uint64_t>(count);
  const auto motor = static_cast<double>(steps_);
  carried_steps_ = std::clamp(carried_steps_, motor - half_play_steps_, motor + half_play_steps_);
  if (errors_.windup_deg != 0.0) {
    const double kept =
        std::exp(-static_cast<double>(count) * degrees_per_step_ / errors_.windup_travel_deg);
    windup_ = kept * windup_ - (direction > 0 ? 1.0 : -1.0) * (1.0 - kept);
  }
  if (errors_.slip_deg != 0.0 && time_s > errors_.slip_time_s) slipped_ = true;
}

AxisSwitches Stage::switches() const {
  return {steps_ < 0, steps_ <= lower_limit_steps_, steps_ >= upper_limit_steps_};
}

double Stage::motor_deg() const {
  return home_deg_ + static_cast<double>(steps_) * degrees_per_step_;
}

double Stage::true_deg() const {
  const auto wave = [](double amplitude_deg, double cycles, double angle_deg, double phase_deg) {
    if (amplitude_deg == 0.0) return 0.0;
    return amplitude_deg * std::sin(optics::radians(cycles * angle_deg + phase_deg));
  };
  const double carried_deg = home_deg_ + carried_steps_ * degrees_per_step_;
  double angle = carried_deg + errors_.zero_deg;
  angle += wave(errors_.eccentricity_deg, 1.0, carried_deg, errors_.eccentricity_phase_deg);
  angle += wave(errors_.encoder_deg, 2.0, carried_deg, errors_.encoder_phase_deg);
  angle += wave(errors_.gear_deg, errors_.gear_cycles * errors_.gear_ratio, motor_deg(),
                errors_.gear_phase_deg);
  if (errors_.windup_deg != 0.0) angle += errors_.windup_deg * windup_;
  if (slipped_) angle += errors_.slip_deg;
  if (errors_.standstill_deg != 0.0) angle += errors_.standstill_deg * gaussian_of(seed_, moves_);
  return angle;
}

}  // namespace umov::plant
