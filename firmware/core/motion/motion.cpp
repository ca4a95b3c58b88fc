#include "firmware/core/motion/motion.hpp"

#include <algorithm>

#include "firmware/core/config/design_parameters.hpp"

namespace umov::firmware {
namespace {

constexpr int detector = static_cast<int>(protocol::Axis::detector);

constexpr std::uint8_t bit(int axis) {
  return static_cast<std::uint8_t>(1u << axis);
}
constexpr void set(std::uint8_t& mask, int axis) {
  mask = static_cast<std::uint8_t>(mask | bit(axis));
}
constexpr void clear(std::uint8_t& mask, int axis) {
  mask = static_cast<std::uint8_t>(mask & ~bit(axis));
}

}  // namespace

Motion::Motion(Board& board, const AxisTable& axes) : settings_(axes), board_(&board) {
  for (int axis = 0; axis < axis_count; ++axis) axes_[index(axis)].attach(board, axis);
}

bool Motion::change_settings(const protocol::SetAxis& change) {
  AxisSettings& axis = settings_[change.axis];
  const std::uint64_t steps_per_second =
      std::uint64_t{axis.steps_per_turn} * change.speed_mdeg_s / 360'000;
  if (change.min_udeg >= change.max_udeg) return false;
  // Zero must lie inside: homing ends there. Two turns keep every move within Profile::max_steps.
  if (change.min_udeg > 0 || change.max_udeg < 0) return false;
  if (change.min_udeg < -720'000'000 || change.max_udeg > 720'000'000) return false;
  if (steps_per_second > step_timer_hz / shortest_step_ticks) return false;
  if (change.take_up_udeg > static_cast<std::uint32_t>(overtravel_udeg)) return false;
  axis.min_udeg = change.min_udeg;
  axis.max_udeg = change.max_udeg;
  axis.speed_mdeg_s = change.speed_mdeg_s;
  axis.acceleration_mdeg_s2 = change.acceleration_mdeg_s2;
  axis.jerk_mdeg_s3 = change.jerk_mdeg_s3;
  axis.take_up_udeg = change.take_up_udeg;
  return true;
}

bool Motion::allowed(int axis, std::int32_t target_udeg) const {
  const AxisSettings& s = settings(axis);
  if (target_udeg == protocol::open_position) return s.open_udeg != 0;
  return target_udeg >= s.min_udeg && target_udeg <= s.max_udeg;
}

std::int32_t Motion::target_steps(int axis, std::int32_t target_udeg) const {
  const AxisSettings& s = settings(axis);
  return steps_from_udeg(target_udeg == protocol::open_position ? s.open_udeg : target_udeg,
                         s.steps_per_turn);
}

void Motion::start(int axis, std::int32_t steps) {
  const AxisSettings& s = settings(axis);
  const MotionLimits limits =
      motion_limits(s.steps_per_turn, s.speed_mdeg_s, s.acceleration_mdeg_s2, s.jerk_mdeg_s3);
  AxisMotion& motion = axes_[index(axis)];
  if (motion.position() == steps) return;
  motion.start(steps, limits, Watch::nothing);
  set(active_mask_, axis);  // also when it did not start: a pressed limit is looked at in tick()
  moved_ = true;
}

void Motion::move(int axis, std::int32_t target_udeg) {
  const std::int32_t target = target_steps(axis, target_udeg);
  const std::int32_t take_up = steps_from_udeg(
      static_cast<std::int32_t>(settings(axis).take_up_udeg), settings(axis).steps_per_turn);
  clear(take_up_mask_, axis);
  if (take_up > 0 && target < axes_[index(axis)].position()) {
    final_steps_[index(axis)] = target;
    set(take_up_mask_, axis);
    start(axis, target - take_up);
  } else {
    start(axis, target);
  }
}

void Motion::move_all(const AxisTargets& targets_udeg) {
  for (int axis = 0; axis < axis_count; ++axis) move(axis, targets_udeg[index(axis)]);
}

void Motion::home(std::uint8_t axis_mask) {
  homing_mask_ = axis_mask;
  homed_mask_ = static_cast<std::uint8_t>(homed_mask_ & ~axis_mask);
  homing_axis_ = -1;
  moved_ = true;
}

void Motion::stop_all() {
  take_up_mask_ = 0;
  homing_mask_ = 0;
  homing_axis_ = -1;
  for (AxisMotion& axis : axes_) axis.request_stop();
  for (AxisMotion& axis : axes_) axis.service();
}

void Motion::follow_up(int axis) {
  AxisMotion& motion = axes_[index(axis)];
  clear(active_mask_, axis);
  const MoveEnd end = motion.end();
  if (end == MoveEnd::lower_limit || end == MoveEnd::upper_limit) {
    if (fault_.fault == protocol::Fault::none) fault_ = {protocol::Fault::limit, axis};
    clear(take_up_mask_, axis);
  } else if ((take_up_mask_ & bit(axis)) != 0) {
    clear(take_up_mask_, axis);
    if (end == MoveEnd::arrived) start(axis, final_steps_[index(axis)]);
  }
}

void Motion::advance_homing() {
  if (homing_axis_ < 0) {
    homing_axis_ = 0;
    while ((homing_mask_ & bit(homing_axis_)) == 0) ++homing_axis_;
    homing_.begin(axes_[index(homing_axis_)], settings(homing_axis_),
                  board_->switches(homing_axis_).home);
    return;
  }
  if (axes_[index(homing_axis_)].moving()) return;
  const Homing::Result result = homing_.advance(board_->switches(homing_axis_).home);
  if (result == Homing::Result::busy) return;
  if (result == Homing::Result::done) {
    set(homed_mask_, homing_axis_);
    clear(homing_mask_, homing_axis_);
  } else {
    fault_ = {result == Homing::Result::limit ? protocol::Fault::limit : protocol::Fault::not_homed,
              homing_axis_};
    homing_mask_ = 0;
  }
  homing_axis_ = -1;
}

void Motion::watch_limits(int axis) {
  const AxisInputs inputs = board_->switches(axis);
  LimitWatch& watch = limits_[index(axis)];
  bool lower = watch.lower.closes(inputs.lower_limit);
  bool upper = watch.upper.closes(inputs.upper_limit);
  AxisMotion& motion = axes_[index(axis)];
  // An axis that is being homed may run into a limit and turn round.
  if (homing_axis_ == axis) (motion.direction() > 0 ? upper : lower) = false;
  if (!lower && !upper) return;
  motion.request_stop();
  if (fault_.fault == protocol::Fault::none) fault_ = {protocol::Fault::limit, axis};
}

void Motion::tick() {
  for (int axis = 0; axis < axis_count; ++axis) {
    AxisMotion& motion = axes_[index(axis)];
    watch_limits(axis);
    motion.service();
    if ((active_mask_ & bit(axis)) == 0) continue;
    if (!motion.moving()) {
      follow_up(axis);
    } else if (motion.end() == MoveEnd::lower_limit || motion.end() == MoveEnd::upper_limit) {
      // Told while it still brakes: the other axes must stop now.
      if (fault_.fault == protocol::Fault::none) fault_ = {protocol::Fault::limit, axis};
    }
  }
  if (homing_mask_ != 0) advance_homing();
}

bool Motion::busy() const {
  if (homing_mask_ != 0 || take_up_mask_ != 0 || active_mask_ != 0) return true;
  for (const AxisMotion& axis : axes_) {
    if (axis.moving()) return true;
  }
  return false;
}

std::int32_t Motion::position_udeg(int axis) const {
  return udeg_from_steps(position_steps(axis), settings(axis).steps_per_turn);
}

int Motion::detector_direction() const {
  return axes_[detector].direction();
}

MotionFault Motion::take_fault() {
  const MotionFault fault = fault_;
  fault_ = {};
  return fault;
}

bool Motion::take_moved() {
  const bool moved = moved_;
  moved_ = false;
  return moved;
}

}  // namespace umov::firmware
