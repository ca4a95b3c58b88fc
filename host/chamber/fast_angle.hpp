// The angle of a cosine, from a table: look-ups in a path's inner loop need no more.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "host/optics/angles.hpp"

namespace umov::chamber {

/// Degrees of the angle whose cosine is in [0, 1], to 1e-4°. In s = √(1 − cosine) the angle,
/// 2 asin(s/√2), is smooth.
inline double angle_deg(double cosine) {
  constexpr std::size_t steps = 1024;
  static const auto table = [] {
    std::array<double, steps + 2> t{};
    for (std::size_t i = 0; i < t.size(); ++i) {
      const double s = std::min(1.0, static_cast<double>(i) / steps);
      t[i] = optics::degrees(2.0 * std::asin(s * std::sqrt(0.5)));
    }
    return t;
  }();
  const double scaled = steps * std::sqrt(std::clamp(1.0 - cosine, 0.0, 1.0));
  const auto lower = static_cast<std::size_t>(scaled);
  return table[lower] + (scaled - static_cast<double>(lower)) * (table[lower + 1] - table[lower]);
}

}  // namespace umov::chamber
