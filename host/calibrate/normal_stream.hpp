// Standard normal deviates that depend on what they are for, not on when they are asked for
// (Philox, Salmon et al. 2011; Box and Muller).
#pragma once

#include <Random123/philox.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>

namespace umov::calibrate {

/// What a stream of random numbers is for: streams of one draw don't overlap.
enum class DrawPurpose : std::uint32_t { truth, noise, drift, linearity_noise };

/// Standard normal deviates that depend on (seed, draw, purpose, scan) alone.
class NormalStream {
 public:
  NormalStream(std::uint64_t seed, std::size_t draw, DrawPurpose purpose, std::size_t scan = 0)
      : key_{{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)}},
        counter_{{0, static_cast<std::uint32_t>(draw), static_cast<std::uint32_t>(purpose),
                  static_cast<std::uint32_t>(scan)}} {}

  double operator()() {
    if (left_ == 0) refill();
    return value_[--left_];
  }

 private:
  void refill() {
    const auto bits = r123::Philox4x32()(counter_, key_);
    ++counter_[0];
    const auto uniform = [](std::uint32_t b) { return (static_cast<double>(b) + 0.5) * 0x1p-32; };
    for (unsigned k = 0; k < 2; ++k) {
      const double radius = std::sqrt(-2.0 * std::log(uniform(bits[2 * k])));
      const double turn = 2.0 * std::numbers::pi * uniform(bits[2 * k + 1]);
      value_[2 * k] = radius * std::cos(turn);
      value_[2 * k + 1] = radius * std::sin(turn);
    }
    left_ = 4;
  }

  r123::Philox4x32::key_type key_;
  r123::Philox4x32::ctr_type counter_;
  double value_[4] = {};
  unsigned left_ = 0;
};

}  // namespace umov::calibrate
