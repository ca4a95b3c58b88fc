// Places on the axis of a table.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <string>

#include "host/errors/error.hpp"

namespace umov::brdf {

/// Entries `lower` and `upper` of an axis and the weight of `upper`, for linear interpolation.
struct AxisPlace {
  std::size_t lower = 0, upper = 0;
  double weight = 0.0;
};

/// Beyond the ends the outermost entry. `axis` rises and is not empty.
inline AxisPlace place_on(std::span<const double> axis, double x) {
  const auto above = std::upper_bound(axis.begin(), axis.end(), x);
  if (above == axis.begin()) return {0, 0, 0.0};
  const auto upper = static_cast<std::size_t>(above - axis.begin());
  if (upper == axis.size()) return {upper - 1, upper - 1, 0.0};
  return {upper - 1, upper, (x - axis[upper - 1]) / (axis[upper] - axis[upper - 1])};
}

/// Throws umov::Error unless `axis` has entries, all finite, from `low` to `high` and rising
/// strictly. `name` is what the axis is called, with its unit.
inline void check_axis(std::span<const double> axis, const std::string& origin,
                       const std::string& name, double low, double high) {
  if (axis.empty()) throw Error({origin, 0, name}, "the axis is empty", "give at least one entry");
  for (std::size_t i = 0; i < axis.size(); ++i) {
    const std::string entry = name + "[" + std::to_string(i) + "]";
    if (!(axis[i] >= low && axis[i] <= high)) {
      throw Error({origin, 0, entry}, std::to_string(axis[i]) + " is out of range",
                  "entries lie from " + std::to_string(low) + " to " + std::to_string(high));
    }
    if (i > 0 && !(axis[i] > axis[i - 1])) {
      throw Error({origin, 0, entry},
                  std::to_string(axis[i]) + " does not rise above the entry before it",
                  "sort the axis and give each entry once");
    }
  }
}

}  // namespace umov::brdf
