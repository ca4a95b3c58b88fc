#include "firmware/core/motion/homing.hpp"

#include <algorithm>

namespace umov::firmware {
namespace {

/// More than a turn: a switch that has not shown by then is not there.
constexpr std::int32_t search_udeg = 400'000'000;
/// Take-up at the end of homing, larger than any play.
constexpr std::int32_t arrival_udeg = 1'000'000;

bool hit_limit(MoveEnd end) {
  return end == MoveEnd::lower_limit || end == MoveEnd::upper_limit;
}

}  // namespace

void Homing::begin(AxisMotion& axis, const AxisSettings& settings, bool home_pressed) {
  axis_ = &axis;
  settings_ = &settings;
  enter(home_pressed ? Stage::release : Stage::search_down);
}

bool Homing::seek(int direction, std::uint32_t speed_mdeg_s, Watch watch) {
  const std::int32_t far = steps_from_udeg(search_udeg, settings_->steps_per_turn);
  const MotionLimits limits =
      motion_limits(settings_->steps_per_turn, std::min(speed_mdeg_s, settings_->speed_mdeg_s),
                    settings_->acceleration_mdeg_s2, settings_->jerk_mdeg_s3);
  return axis_->start(axis_->position() + direction * far, limits, watch);
}

Homing::Result Homing::enter(Stage stage) {
  if (start(stage)) return Result::busy;
  // At the lower limit already: search the other way.
  if (stage == Stage::search_down && start(Stage::search_up)) return Result::busy;
  return Result::limit;
}

bool Homing::start(Stage stage) {
  stage_ = stage;
  const std::uint32_t fast = settings_->homing_mdeg_s;
  const std::uint32_t slow = settings_->approach_mdeg_s;
  const MotionLimits usual =
      motion_limits(settings_->steps_per_turn, settings_->speed_mdeg_s,
                    settings_->acceleration_mdeg_s2, settings_->jerk_mdeg_s3);
  switch (stage) {
    case Stage::search_down:
      return seek(-1, fast, Watch::home_pressed);
    case Stage::search_up:
      return seek(+1, fast, Watch::home_pressed);
    case Stage::release:
      return seek(+1, fast, Watch::home_released);
    case Stage::approach:
      return seek(-1, slow, Watch::home_pressed);
    case Stage::edge:
      return seek(+1, std::max<std::uint32_t>(1, slow / 4), Watch::home_released);
    case Stage::below:
      return axis_->start(-steps_from_udeg(arrival_udeg, settings_->steps_per_turn), usual,
                          Watch::nothing);
    case Stage::arrive:
      return axis_->start(0, usual, Watch::nothing);
  }
  return false;
}

Homing::Result Homing::after_search(bool home_pressed) {
  switch (axis_->end()) {
    case MoveEnd::edge:
      // Found on the way up, the axis may have passed a narrow switch: come down on it again.
      return enter(stage_ == Stage::search_up && !home_pressed ? Stage::search_down
                                                               : Stage::release);
    case MoveEnd::lower_limit:
      return enter(Stage::search_up);
    default:
      return Result::not_found;
  }
}

Homing::Result Homing::after_edge() {
  axis_->make_zero(axis_->edge_position());
  return enter(Stage::below);
}

Homing::Result Homing::advance(bool home_pressed) {
  const MoveEnd end = axis_->end();
  switch (stage_) {
    case Stage::search_down:
    case Stage::search_up:
      return after_search(home_pressed);
    case Stage::release:
    case Stage::approach:
    case Stage::edge:
      if (hit_limit(end)) return Result::limit;
      if (end != MoveEnd::edge) return Result::not_found;
      if (stage_ == Stage::release) return enter(Stage::approach);
      if (stage_ == Stage::approach) return enter(Stage::edge);
      return after_edge();
    case Stage::below:
      if (end != MoveEnd::arrived) return Result::limit;
      return enter(Stage::arrive);
    case Stage::arrive:
      return end == MoveEnd::arrived ? Result::done : Result::limit;
  }
  return Result::not_found;
}

}  // namespace umov::firmware
