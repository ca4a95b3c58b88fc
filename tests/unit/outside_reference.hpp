// A chopper that nobody here drives: edges of its reference output and the light that it lets pass.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <random>

namespace umov::test {

/// Turns at its nominal frequency with a slow swing; its light is a sine in phase with the
/// edges. `jitter_rad`: rms of the edges alone, as of an unsteady photo-interrupter.
struct OutsideReference {
  double frequency_hz = 1000;
  double wander = 0;  ///< relative amplitude of the frequency
  double wander_period_s = 10;
  double jitter_rad = 0;
  double starts_s = 0;
  double stops_s = std::numeric_limits<double>::infinity();

  /// Phase, turns.
  double turns(double time_s) const {
    const double rate = 2 * std::numbers::pi / wander_period_s;
    return frequency_hz * (time_s + wander / rate * (1 - std::cos(rate * time_s)));
  }
  /// When it has made so many turns.
  double moment(double number) const {
    double t = number / frequency_hz;
    for (int i = 0; i < 6; ++i) {
      const double rate = 2 * std::numbers::pi / wander_period_s;
      const double speed = frequency_hz * (1 + wander * std::sin(rate * t));
      t -= (turns(t) - number) / speed;
    }
    return t;
  }
  /// When edge `number` comes; jitter depends on the number alone.
  double edge_s(std::uint64_t number) const {
    double at = moment(static_cast<double>(number));
    if (jitter_rad > 0) {
      std::mt19937_64 random(number * 0x9E37'79B9'7F4A'7C15ull);
      std::normal_distribution<double> normal(0, jitter_rad);
      at += normal(random) / (2 * std::numbers::pi * frequency_hz);
    }
    return at;
  }
  double next_edge_s(double after_s) const {
    after_s = std::max(after_s, starts_s);
    const double before = std::floor(turns(after_s));
    auto number = static_cast<std::uint64_t>(std::max(before - 1, 0.0));
    while (edge_s(number) <= after_s) ++number;
    const double edge = edge_s(number);
    return edge < stops_s ? edge : std::numeric_limits<double>::infinity();
  }
  /// -1 to 1; where the chopper has stopped it stays.
  double light(double time_s) const {
    return std::sin(2 * std::numbers::pi * turns(std::min(time_s, stops_s)));
  }
};

}  // namespace umov::test
