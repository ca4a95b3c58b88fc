// Jerk-limited move of a whole number of steps, and when each step is due.
//
// The move has seven segments: jerk T1, constant acceleration T2, jerk T1, cruise T3, and the
// mirror image. Durations are whole timer ticks, rounded up from the time-optimal ones, and the
// jerk follows from distance and durations,
//     J = D / (T1 (T1 + T2) (2 T1 + T2 + T3)),
// so that the move ends exactly on its target and speed, acceleration and jerk stay within their
// limits. Step k (1 … D) is due when the distance is k - 1/2; its time is found to the nearest tick
// from the segment's cubic, never from the step before, so nothing accumulates.
// A stop shortens T1, T2 or T3 to what has passed: the past stays as it was.
// Integers only.
#pragma once

#include <array>
#include <cstdint>

namespace umov::firmware {

/// Limits of a move, in steps per second (squared, cubed) as fractions over `denominator`.
struct MotionLimits {
  std::uint64_t speed = 0;
  std::uint64_t acceleration = 0;
  std::uint64_t jerk = 0;
  std::uint64_t denominator = 1;
};

/// Limits given in millidegrees.
constexpr MotionLimits motion_limits(std::uint32_t steps_per_turn, std::uint32_t speed_mdeg_s,
                                     std::uint32_t acceleration_mdeg_s2,
                                     std::uint32_t jerk_mdeg_s3) {
  return {std::uint64_t{steps_per_turn} * speed_mdeg_s,
          std::uint64_t{steps_per_turn} * acceleration_mdeg_s2,
          std::uint64_t{steps_per_turn} * jerk_mdeg_s3, 360'000};
}

/// Durations of the segments, timer ticks.
struct SegmentTicks {
  std::uint64_t jerk = 0;
  std::uint64_t acceleration = 0;
  std::uint64_t cruise = 0;

  constexpr std::uint64_t total() const { return 4 * jerk + 2 * acceleration + cruise; }
  /// Half the move rounded up: the two halves mirror each other.
  constexpr std::uint64_t half() const { return (total() + 1) / 2; }
};

class Profile {
 public:
  /// Distances are in steps with this many fraction bits.
  static constexpr unsigned fraction_bits = 36;
  /// Longest move, steps.
  static constexpr std::uint32_t max_steps = 1u << 21;

  constexpr Profile() = default;
  /// Time-optimal move of `steps` (1 … max_steps) at `timer_hz`, up to the rounding of durations.
  Profile(std::uint32_t steps, const MotionLimits& limits, std::uint32_t timer_hz);

  /// The same move, coming to a controlled stop as soon as possible after `ticks`.
  Profile stopped_after(std::uint64_t ticks) const;

  const SegmentTicks& durations() const { return durations_; }
  std::uint64_t total_ticks() const { return total_; }
  /// Steps the move makes in all.
  std::uint32_t steps() const { return steps_; }
  /// Distance after `ticks`, with `fraction_bits`.
  std::uint64_t distance_at(std::uint64_t ticks) const;
  /// Tick at which step `number` (1 … steps()) is due; `guess` is any tick near it.
  std::uint64_t step_tick(std::uint32_t number, std::uint64_t guess) const;

 private:
  /// s(t) = start + u (linear + u (square + u cubic)), u = (t - begin) / 2^exponent.
  struct Segment {
    std::uint64_t begin = 0;
    std::uint64_t start = 0;
    std::uint64_t linear = 0;
    std::uint64_t square = 0;
    std::int64_t cubic = 0;
    unsigned exponent = 0;
  };

  void build_segments();
  const Segment& segment_at(std::uint64_t ticks) const;
  std::uint64_t rising_tick(std::uint64_t distance, std::uint64_t guess) const;

  SegmentTicks durations_{};
  std::uint64_t distance_ = 0;
  // Worked out beforehand for the step interrupt.
  std::uint64_t total_ = 0;
  std::uint64_t half_ = 0;
  std::uint32_t steps_ = 0;
  std::array<Segment, 4> segments_{};
};

}  // namespace umov::firmware
