// The clock of pipes to real devices.
#pragma once

#include <chrono>
#include <cstdint>

namespace umov::instrument {

/// Microseconds since the Unix epoch by a clock that never jumps: timeouts must not depend on
/// someone setting the date.
class WallClock {
 public:
  std::uint64_t now_us() const {
    return start_us_ + microseconds_of(std::chrono::steady_clock::now() - start_);
  }

 private:
  template <class Duration>
  static std::uint64_t microseconds_of(Duration duration) {
    return static_cast<std::uint64_t>(
        std::chrono::duration_cast<std::chrono::microseconds>(duration).count());
  }
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  std::uint64_t start_us_ = microseconds_of(std::chrono::system_clock::now().time_since_epoch());
};

}  // namespace umov::instrument
