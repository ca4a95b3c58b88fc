// The hand controller: steps of one axis, taken while nothing else moves.
#include <algorithm>

#include "firmware/core/controller.hpp"

namespace umov::firmware {

void Controller::jog(int axis, std::int32_t by_udeg) {
  if (axis < 0 || axis >= axis_count || by_udeg == 0) return;
  if (safety_.latched() || sequencer_.running()) return;
  if (hand_axis_ < 0) {
    if (motion_.busy() || (motion_.homed_mask() & (1u << axis)) == 0) return;
    hand_target_udeg_ = motion_.position_udeg(axis);
  } else if (hand_axis_ != axis) {
    return;
  }
  const std::int64_t target = hand_target_udeg_ + by_udeg;
  // INT32_MIN is no angle but `open`.
  if (target <= INT32_MIN || target > INT32_MAX ||
      !motion_.allowed(axis, static_cast<std::int32_t>(target))) {
    return;
  }
  hand_target_udeg_ = target;
  hand_axis_ = axis;
  follow_hand();
}

void Controller::follow_hand() {
  if (hand_axis_ < 0) return;
  if (safety_.latched() || sequencer_.running()) {
    hand_axis_ = -1;
    return;
  }
  if (motion_.busy()) return;
  const auto target = static_cast<std::int32_t>(hand_target_udeg_);
  const AxisSettings& settings = motion_.settings(hand_axis_);
  if (steps_from_udeg(target, settings.steps_per_turn) == motion_.position_steps(hand_axis_)) {
    hand_axis_ = -1;
    return;
  }
  motion_.move(hand_axis_, target);
}

void Controller::stop_by_hand(bool emergency) {
  hand_axis_ = -1;
  if (emergency) return raise(protocol::Fault::emergency_stop, -1);
  sequencer_.pause();
  motion_.stop_all();
}

HandView Controller::hand_view(int axis) const {
  return {state(), safety_.first(), motion_.homed_mask(), motion_.position_udeg(axis)};
}

}  // namespace umov::firmware
