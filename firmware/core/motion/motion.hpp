// The six axes together: targets in angles, soft limits, take-up, homing, controlled stops.
#pragma once

#include <array>
#include <cstdint>

#include "firmware/core/config/axis_settings.hpp"
#include "firmware/core/config/design_parameters.hpp"
#include "firmware/core/motion/axis_motion.hpp"
#include "firmware/core/motion/homing.hpp"
#include "firmware/core/port.hpp"

namespace umov::firmware {

using AxisTargets = std::array<std::int32_t, axis_count>;  ///< microdegrees, or open_position

/// Something that went wrong on an axis since it was last asked for.
struct MotionFault {
  protocol::Fault fault = protocol::Fault::none;
  int axis = -1;
};

/// Tells a switch that closes from one that bounces or was closed before.
class SwitchWatch {
 public:
  /// Once a tick.
  bool closes(bool pressed) {
    const bool anew = pressed && released_ticks_ >= limit_release_ticks;
    if (pressed) {
      released_ticks_ = 0;
    } else if (released_ticks_ < limit_release_ticks) {
      ++released_ticks_;
    }
    return anew;
  }

 private:
  std::uint8_t released_ticks_ = 0;
};

struct LimitWatch {
  SwitchWatch lower, upper;
};

class Motion {
 public:
  explicit Motion(Board& board, const AxisTable& axes = default_axes);

  const AxisSettings& settings(int axis) const { return settings_[index(axis)]; }
  /// At rest only. False when the limits are not in order, the speed is beyond the step timer or
  /// the take-up is longer than the room beyond the soft limit; nothing is changed then.
  bool change_settings(const protocol::SetAxis& change);

  /// Whether `target` is a position of the axis: within its soft limits, or `open` if it has that.
  bool allowed(int axis, std::int32_t target_udeg) const;
  /// Starts moving one axis; the target must be allowed and the axis at rest.
  void move(int axis, std::int32_t target_udeg);
  /// Starts moving all axes at once.
  void move_all(const AxisTargets& targets_udeg);
  /// Starts homing the axes of the mask, one after the other.
  void home(std::uint8_t axis_mask);
  /// Stops everything under control; take-ups and homing are given up.
  void stop_all();
  /// The driver lost steps: the position of the axis is not known any more.
  void forget_position(int axis) { homed_mask_ &= static_cast<std::uint8_t>(~(1u << axis)); }

  std::uint32_t on_step_timer(int axis) { return axes_[index(axis)].on_step_timer(); }
  /// Once a millisecond. A limit switch that closes is a fault whatever the axis does; one that it
  /// stood on before is not: the axis may leave it.
  void tick();

  /// True while an axis moves, a take-up is due or homing goes on.
  bool busy() const;
  bool homing() const { return homing_mask_ != 0; }
  std::uint8_t homed_mask() const { return homed_mask_; }
  std::int32_t position_steps(int axis) const { return axes_[index(axis)].position(); }
  std::int32_t position_udeg(int axis) const;
  /// Sense of the last move of the detector arm that was not zero, its take-up included; 1 at
  /// start.
  int detector_direction() const;
  /// The oldest limit or homing failure not yet taken.
  MotionFault take_fault();
  /// Whether a move has been started since this was last asked.
  bool take_moved();

 private:
  static constexpr std::size_t index(int axis) { return static_cast<std::size_t>(axis); }
  std::int32_t target_steps(int axis, std::int32_t target_udeg) const;
  void start(int axis, std::int32_t steps);
  void follow_up(int axis);
  void watch_limits(int axis);
  void advance_homing();

  AxisTable settings_;
  std::array<AxisMotion, axis_count> axes_{};
  std::array<std::int32_t, axis_count> final_steps_{};  // where a take-up ends
  std::uint8_t take_up_mask_ = 0;
  std::uint8_t active_mask_ = 0;  // moves whose end has not been looked at
  std::uint8_t homed_mask_ = 0;
  std::uint8_t homing_mask_ = 0;
  int homing_axis_ = -1;
  Homing homing_{};
  std::array<LimitWatch, axis_count> limits_{};
  Board* board_;
  bool moved_ = false;
  MotionFault fault_{};
};

}  // namespace umov::firmware
