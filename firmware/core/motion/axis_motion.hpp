// One axis: moves from rest to rest, step by step in the timer's interrupt, and stops under
// control.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "firmware/core/config/axis_settings.hpp"
#include "firmware/core/motion/profile.hpp"
#include "firmware/core/port.hpp"

namespace umov::firmware {

/// What ends a move early.
enum class Watch : std::uint8_t {
  nothing,
  home_pressed,   ///< the home switch goes from released to pressed
  home_released,  ///< the home switch goes from pressed to released
};

/// How the last move ended.
enum class MoveEnd : std::uint8_t { arrived, stopped, lower_limit, upper_limit, edge };

/// Contexts: on_step_timer() in the axis' timer interrupt, everything else in the main loop. The
/// step counter changes only with a step, so the position is known whatever ends a move.
class AxisMotion {
 public:
  void attach(Board& board, int axis) {
    board_ = &board;
    axis_ = axis;
  }

  /// Starts a move to `target_steps` from rest. False when it is where it should be, or when the
  /// limit switch in that direction is pressed (then the end is that limit).
  bool start(std::int32_t target_steps, const MotionLimits& limits, Watch watch);
  /// Timer interrupt: emits the step that is due; ticks to the next, 0 = at rest.
  std::uint32_t on_step_timer();
  /// Asks for a controlled stop.
  void request_stop();
  /// Once a millisecond: plans a stop that was asked for.
  void service();

  bool moving() const { return moving_.load(std::memory_order_acquire); }
  MoveEnd end() const { return end_.load(std::memory_order_relaxed); }
  std::int32_t position() const { return position_.load(std::memory_order_relaxed); }
  /// Step counter at the edge the move watched for; valid when end() is `edge`.
  std::int32_t edge_position() const { return edge_position_; }
  /// At rest only: what was `steps` becomes zero.
  void make_zero(std::int32_t steps) { position_.store(position() - steps); }
  /// Sense of the last move, +1 or -1.
  int direction() const { return direction_; }

 private:
  void inspect_switches();
  bool plan_stop(std::uint64_t due);

  Board* board_ = nullptr;
  int axis_ = 0;
  std::array<Profile, 2> profiles_{};
  std::atomic<std::uint8_t> active_{0};
  std::atomic<bool> moving_{false};
  std::atomic<bool> stop_requested_{false};
  std::atomic<MoveEnd> end_{MoveEnd::arrived};
  std::atomic<std::int32_t> position_{0};
  std::int32_t edge_position_ = 0;
  std::int32_t direction_ = 1;
  Watch watch_ = Watch::nothing;
  bool home_was_pressed_ = false;
  bool stop_planned_ = false;
  std::uint32_t steps_done_ = 0;
  std::uint64_t next_tick_ = 0;        // profile time of the step the timer runs towards
  std::uint64_t interval_ = 0;         // ticks from the step before to that one
  std::uint64_t interval_change_ = 0;  // by which it differs from the one before, modulo 2^64
};

}  // namespace umov::firmware
