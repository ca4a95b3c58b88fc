#include "firmware/core/lockin/reference_lock.hpp"

#include <algorithm>

#include "firmware/core/integer/wide.hpp"

namespace umov::firmware {
namespace {

constexpr unsigned part_bits = 16;
constexpr std::uint64_t one_tick = std::uint64_t{1} << part_bits;
/// An edge lies somewhere within the tick at which it was counted.
constexpr std::int32_t half_tick = static_cast<std::int32_t>(one_tick / 2);
/// Edges further apart are none of one reference; far above the longest period.
constexpr std::uint32_t longest_wait = reference_clock_hz / 2;

constexpr std::uint64_t period_of(std::uint32_t mhz) {
  return std::uint64_t{reference_clock_hz} * 1000 * one_tick / mhz;
}
constexpr std::uint64_t shortest_period = period_of(highest_reference_mhz);
constexpr std::uint64_t longest_period = period_of(lowest_reference_mhz);
static_assert(longest_period < std::uint64_t{longest_wait} * one_tick);

}  // namespace

std::uint64_t PhaseLine::turns_at(std::uint32_t moment) const {
  const std::int64_t away =
      std::int64_t{static_cast<std::int32_t>(moment - tick)} * std::int64_t{one_tick} - part;
  const std::uint64_t size = static_cast<std::uint64_t>(away < 0 ? -away : away);
  const std::uint64_t moved = multiply_divide(size, std::uint64_t{1} << 32, period);
  const std::uint64_t here = std::uint64_t{turns} << 32;
  return away < 0 ? here - moved : here + moved;
}

std::uint32_t PhaseLine::step_per_sample() const {
  constexpr std::uint64_t scaled = std::uint64_t{reference_ticks_per_sample} << (32 + part_bits);
  static_assert(scaled >> (32 + part_bits) == reference_ticks_per_sample);
  return static_cast<std::uint32_t>((scaled + period / 2) / period);
}

bool ReferenceLock::in_range() const {
  return line_.period >= shortest_period && line_.period <= longest_period;
}

std::uint32_t ReferenceLock::edges_to_remember() const {
  constexpr std::uint64_t remembered = std::uint64_t{reference_clock_hz} / 4 * one_tick;
  if (line_.period <= remembered / memory) return memory;
  return std::max(short_memory, static_cast<std::uint32_t>(remembered / line_.period));
}

void ReferenceLock::begin(std::uint32_t tick) {
  if (locked()) ++losses_;
  line_ = {.turns = 0, .tick = tick, .part = half_tick, .period = one_tick};
  last_edge_ = tick;
  edges_ = 1;
  good_ = 0;
  strays_ = 0;
}

void ReferenceLock::forget() {
  if (locked()) ++losses_;
  edges_ = 0;
  good_ = 0;
  too_fast_or_slow_ = false;
}

void ReferenceLock::take_first_period(std::uint32_t ticks) {
  line_.tick += ticks;
  line_.turns += 1;
  line_.period = std::uint64_t{ticks} * one_tick;
  too_fast_or_slow_ = !in_range();
  if (too_fast_or_slow_) return begin(line_.tick);
  edges_ = 2;
}

void ReferenceLock::on_edge(std::uint32_t tick) {
  if (edges_ == 0) return begin(tick);
  const std::uint32_t ticks = tick - line_.tick;
  if (edges_ == 1) return take_first_period(ticks);

  const std::int64_t since = std::int64_t{ticks} * std::int64_t{one_tick} + half_tick - line_.part;
  const auto passed = static_cast<std::uint64_t>(since > 0 ? since : 0);
  const std::uint64_t periods = (passed + line_.period / 2) / line_.period;
  if (periods > periods_allowed) return begin(tick);
  const std::uint64_t due = periods * line_.period;
  const bool late = passed > due;
  const std::uint64_t error = late ? passed - due : due - passed;
  if (periods == 0 || error > line_.period / 8) {
    // While nothing is locked the line itself may be what is wrong.
    if (!locked() || ++strays_ > strays_allowed) begin(tick);
    return;
  }
  strays_ = 0;
  last_edge_ = tick;
  follow(error, late, static_cast<std::uint32_t>(periods));
  too_fast_or_slow_ = !in_range();
  if (too_fast_or_slow_) return begin(tick);
  if (locked()) return;
  good_ = error <= line_.period / 32 ? good_ + 1 : 0;
}

/// The edge `periods` after the last one was off by `error`.
void ReferenceLock::follow(std::uint64_t error, bool late, std::uint32_t periods) {
  edges_ = std::min(edges_ + 1, edges_to_remember());
  const std::uint64_t n = edges_;
  const std::uint64_t weight = n * (n + 1);
  const std::uint64_t moved = (error * (2 * (2 * n - 1)) + weight / 2) / weight;
  const std::uint64_t stretched = (error * 6 + weight * periods / 2) / (weight * periods);

  const std::uint64_t due = periods * line_.period;
  // From the old place to the new one, in parts of a tick; `part` is one of them, so positive.
  const std::uint64_t way =
      static_cast<std::uint64_t>(line_.part) + (late ? due + moved : due - moved);
  line_.turns += periods;
  line_.tick += static_cast<std::uint32_t>(way / one_tick);
  line_.part = static_cast<std::int32_t>(way % one_tick);
  line_.period = late ? line_.period + stretched : line_.period - stretched;
}

void ReferenceLock::watch(std::uint32_t now) {
  if (edges_ == 0) return;
  const std::uint32_t waited = now - line_.tick;
  // An edge that the loop has moved ahead of now.
  if (static_cast<std::int32_t>(waited) < 0) return;
  const std::uint64_t limit = periods_allowed * line_.period / one_tick;
  if (waited > longest_wait || (edges_ > 1 && waited > limit)) forget();
}

protocol::ReferenceState ReferenceLock::state() const {
  using protocol::ReferenceState;
  if (locked()) return ReferenceState::locked;
  if (edges_ == 0) return ReferenceState::absent;
  return too_fast_or_slow_ ? ReferenceState::out_of_range : ReferenceState::unsteady;
}

std::uint32_t ReferenceLock::frequency_mhz() const {
  if (!locked()) return 0;
  constexpr std::uint64_t scaled = std::uint64_t{reference_clock_hz} * 1000 * one_tick;
  return static_cast<std::uint32_t>((scaled + line_.period / 2) / line_.period);
}

}  // namespace umov::firmware
