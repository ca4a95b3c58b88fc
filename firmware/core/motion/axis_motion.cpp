#include "firmware/core/motion/axis_motion.hpp"

#include <algorithm>

#include "firmware/core/config/design_parameters.hpp"

namespace umov::firmware {

bool AxisMotion::start(std::int32_t target_steps, const MotionLimits& limits, Watch watch) {
  const std::int32_t distance = target_steps - position();
  end_ = MoveEnd::arrived;
  if (distance == 0) return false;
  const int direction = distance > 0 ? 1 : -1;
  const AxisInputs inputs = board_->switches(axis_);
  if (direction > 0 ? inputs.upper_limit : inputs.lower_limit) {
    end_ = direction > 0 ? MoveEnd::upper_limit : MoveEnd::lower_limit;
    return false;
  }
  direction_ = direction;
  board_->set_direction(axis_, direction);
  watch_ = watch;
  home_was_pressed_ = inputs.home;
  steps_done_ = 0;
  stop_requested_ = false;
  stop_planned_ = false;
  Profile& profile = profiles_[0];
  profile = Profile(static_cast<std::uint32_t>(distance > 0 ? distance : -distance), limits,
                    step_timer_hz);
  active_ = 0;
  next_tick_ = profile.step_tick(1, profile.total_ticks());
  interval_ = next_tick_;
  interval_change_ = 0;
  moving_.store(true, std::memory_order_release);
  board_->start_step_timer(
      axis_, static_cast<std::uint32_t>(std::min<std::uint64_t>(next_tick_, UINT32_MAX)));
  return true;
}

void AxisMotion::inspect_switches() {
  const AxisInputs inputs = board_->switches(axis_);
  if (direction_ > 0 ? inputs.upper_limit : inputs.lower_limit) {
    if (!stop_requested_) {
      end_ = direction_ > 0 ? MoveEnd::upper_limit : MoveEnd::lower_limit;
      stop_requested_ = true;
    }
  }
  if (watch_ == Watch::nothing) return;
  const bool edge = watch_ == Watch::home_pressed ? inputs.home && !home_was_pressed_
                                                  : !inputs.home && home_was_pressed_;
  home_was_pressed_ = inputs.home;
  if (edge) {
    watch_ = Watch::nothing;
    edge_position_ = position();
    if (!stop_requested_) end_ = MoveEnd::edge;
    stop_requested_ = true;
  }
}

std::uint32_t AxisMotion::on_step_timer() {
  board_->step(axis_);
  position_.store(position() + direction_, std::memory_order_relaxed);
  ++steps_done_;
  inspect_switches();
  const Profile& profile = profiles_[active_];
  if (steps_done_ >= profile.steps()) {
    moving_.store(false, std::memory_order_release);
    return 0;
  }
  const std::uint64_t due = next_tick_;
  // Intervals change steadily: the guess is usually right to a tick, and one look at the cubic
  // enough.
  next_tick_ = profile.step_tick(steps_done_ + 1, due + interval_ + interval_change_);
  const std::uint64_t interval = std::max<std::uint64_t>(1, next_tick_ - due);
  interval_change_ = interval - interval_;
  interval_ = interval;
  return static_cast<std::uint32_t>(std::min<std::uint64_t>(interval_, UINT32_MAX));
}

void AxisMotion::request_stop() {
  if (!moving() || stop_requested_) return;
  end_ = MoveEnd::stopped;
  stop_requested_ = true;
}

bool AxisMotion::plan_stop(std::uint64_t due) {
  // The stop branches off a little later than the step that is due next, so that steps can go on
  // while it is planned; both profiles agree until then.
  const std::uint8_t active = active_;
  const std::uint64_t branch = due + stop_planning_ticks;
  profiles_[active ^ 1u] = profiles_[active].stopped_after(branch);
  board_->mask_interrupts();
  const bool in_time = next_tick_ <= branch;
  if (in_time) active_ = static_cast<std::uint8_t>(active ^ 1u);
  board_->unmask_interrupts();
  return in_time;
}

void AxisMotion::service() {
  if (!moving() || !stop_requested_ || stop_planned_) return;
  board_->mask_interrupts();
  const bool crawling = moving() && interval_ > crawl_ticks;
  const std::uint64_t due = next_tick_;
  if (crawling) {
    board_->stop_step_timer(axis_);
    moving_ = false;
  }
  board_->unmask_interrupts();
  if (!crawling) stop_planned_ = plan_stop(due);
}

}  // namespace umov::firmware
