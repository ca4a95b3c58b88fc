// Degrees at user surfaces, radians inside: the only place where one becomes the other.
#pragma once

#include <numbers>

namespace umov::optics {

inline constexpr double pi = std::numbers::pi;

/// Degrees to radians.
constexpr double radians(double degrees) {
  return degrees * (pi / 180.0);
}

/// Radians to degrees.
constexpr double degrees(double radians) {
  return radians * (180.0 / pi);
}

}  // namespace umov::optics
