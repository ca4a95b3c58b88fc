// Frequency and phase of an external reference from the times of its rising edges: a digital
// phase-locked loop in integers.
#pragma once

#include <cstdint>

#include "firmware/core/config/design_parameters.hpp"
#include "protocol/messages.hpp"

namespace umov::firmware {

/// The phase as a straight line through time: what detection needs of a lock.
struct PhaseLine {
  std::uint32_t turns = 0;         ///< whole turns at `tick`, counted since the lock began
  std::uint32_t tick = 0;          ///< of the reference clock, modulo 2^32
  std::int32_t part = 0;           ///< fraction of that tick, 2^-16
  std::uint64_t period = 1 << 16;  ///< reference clock, 2^-16 ticks

  /// Turns at a moment of the reference clock at most 2^30 ticks (6 s) away, 2^-32; goes below
  /// turn 0 modulo 2^64. To the nearest.
  std::uint64_t turns_at(std::uint32_t moment) const;
  /// Phase from one ADC sample to the next, 2^-32 turns, to the nearest.
  std::uint32_t step_per_sample() const;
};

/// Each edge is predicted from the ones before; where it comes off by e, phase and period move by
///
///     a e,  a = 2 (2n - 1) / (n (n + 1)),     b e,  b = 6 / (n (n + 1)),
///
/// which is the least-squares line through the last n edges as long as n counts them all (R. E.
/// Kalman's filter of a straight line; D. Simon, Optimal State Estimation, 2006, ch. 5: recursive
/// least squares). n stops at `memory`, at low frequencies at the edges of the last quarter of a
/// second: older ones fade, so that the loop follows a chopper that wanders. White jitter of 32
/// edges reaches the phase by 0.29 of itself, of 12 by 0.47.
///
/// Contexts: on_edge() in the capture interrupt; everything else from less urgent ones, which keep
/// that interrupt out meanwhile.
class ReferenceLock {
 public:
  /// Edges that are remembered, at most and at least.
  static constexpr std::uint32_t memory = 32;
  static constexpr std::uint32_t short_memory = 12;
  /// Locked after so many edges in a row, each where it was predicted within 1/32 of a period.
  static constexpr std::uint32_t lock_edges = 10;
  /// An edge further off than 1/8 of a period is no edge of this reference. The lock outlasts so
  /// many in a row and is lost at the next, or after more than so many periods without any.
  static constexpr std::uint32_t strays_allowed = 3;
  static constexpr std::uint32_t periods_allowed = 4;

  /// Rising edge within tick `tick` of the reference clock. Edges come in order.
  void on_edge(std::uint32_t tick);
  /// At least each 100 ms: notices that edges stay away.
  void watch(std::uint32_t now);

  bool locked() const { return good_ >= lock_edges; }
  protocol::ReferenceState state() const;
  /// Frequency while locked, millihertz, to the nearest; else 0.
  std::uint32_t frequency_mhz() const;
  /// Meaningful while locked.
  const PhaseLine& line() const { return line_; }
  /// While locked: when the last edge came that was where it was predicted, reference clock.
  std::uint32_t last_edge() const { return last_edge_; }
  /// Differs after each loss of the lock: turns are counted anew.
  std::uint32_t losses() const { return losses_; }

 private:
  void begin(std::uint32_t tick);
  void take_first_period(std::uint32_t ticks);
  void forget();
  bool in_range() const;
  std::uint32_t edges_to_remember() const;
  void follow(std::uint64_t error, bool late, std::uint32_t periods);

  PhaseLine line_{};
  std::uint32_t last_edge_ = 0;
  std::uint32_t edges_ = 0;  ///< of this line, at most `memory`; 0 = none has come
  std::uint32_t good_ = 0;
  std::uint32_t strays_ = 0;
  std::uint32_t losses_ = 0;
  bool too_fast_or_slow_ = false;
};

}  // namespace umov::firmware
