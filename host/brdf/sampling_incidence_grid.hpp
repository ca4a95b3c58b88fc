// The incidences for which samplers keep tables, densest towards grazing.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "host/optics/angles.hpp"

namespace umov::brdf {

struct IncidenceGrid {
  static constexpr std::size_t count = 36;

  /// Node `index`, radians, from 0 to a little below π/2.
  static double theta(std::size_t index) {
    const double s = 1.0 - static_cast<double>(index) / (static_cast<double>(count) - 0.5);
    return 0.5 * optics::pi * (1.0 - s * s);
  }

  /// Between node `lower` and the next, at `share` in [0, 1] of the way. Beyond the last node that
  /// node alone.
  struct Place {
    std::size_t lower;
    double share;
  };

  static Place locate(double theta_i) {
    const double s = std::sqrt(std::max(0.0, 1.0 - theta_i / (0.5 * optics::pi)));
    const double position = std::clamp((1.0 - s) * (static_cast<double>(count) - 0.5), 0.0,
                                       static_cast<double>(count - 1));
    const auto lower = std::min(static_cast<std::size_t>(position), count - 2);
    return {lower, position - static_cast<double>(lower)};
  }
};

}  // namespace umov::brdf
