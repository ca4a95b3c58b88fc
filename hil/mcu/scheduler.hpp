// Virtual time of the emulated chip and what is due when.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <vector>

namespace umov::mcu {

/// Moments and durations in 1/336 MHz: every clock of the chip that is used (168, 84, 42, 21, 16
/// and 8 MHz, 32 kHz) has a whole number of them. 64 bits last 1,700 years.
using Time = std::uint64_t;
inline constexpr Time time_per_second = 336'000'000;
inline constexpr Time time_per_us = time_per_second / 1'000'000;
inline constexpr Time never = std::numeric_limits<Time>::max();

constexpr double seconds(Time t) {
  return static_cast<double>(t) / static_cast<double>(time_per_second);
}

/// Events of the peripherals, each in a slot that is set again and again. Events of one moment
/// happen in the order of their slots, so a run is the same every time.
class Scheduler {
 public:
  using Slot = std::size_t;

  Slot add(std::function<void()> action);
  void set(Slot slot, Time at);
  void clear(Slot slot) { set(slot, never); }
  /// The next moment at which something happens.
  Time next() const { return next_; }
  /// What is due up to `limit` happens, in order; during each event now() is its own moment.
  /// Afterwards now() is `limit`, or later if it was already.
  void run_until(Time limit);
  Time now() const { return now_; }

 private:
  struct Event {
    Time at = never;
    std::function<void()> action;
  };
  void find_next();

  std::vector<Event> events_;
  Time now_ = 0;
  Time next_ = never;
  Slot next_slot_ = 0;
};

}  // namespace umov::mcu
