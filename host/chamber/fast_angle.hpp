// Angles of cosines and cosines of angles from tables: a path's inner loop needs no more.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "host/optics/angles.hpp"

namespace umov::chamber {

struct Turn {
  double cosine, sine;
};

/// Made when the program starts: local tables would be asked each time whether they are made.
struct AngleTables {
  static constexpr std::size_t steps = 1024, turns = 256;
  std::array<double, steps + 2> deg;
  std::array<Turn, turns + 1> turn;

  AngleTables() {
    for (std::size_t i = 0; i < deg.size(); ++i) {
      const double s = std::min(1.0, static_cast<double>(i) / steps);
      deg[i] = optics::degrees(2.0 * std::asin(s * std::sqrt(0.5)));
    }
    for (std::size_t i = 0; i < turn.size(); ++i) {
      const double a = 2.0 * optics::pi * static_cast<double>(i) / turns;
      turn[i] = {std::cos(a), std::sin(a)};
    }
  }
};
inline const AngleTables angle_tables;

/// Degrees of the angle whose cosine is in [0, 1], to 1e-4°. In s = √(1 − cosine) the angle,
/// 2 asin(s/√2), is smooth.
inline double angle_deg(double cosine) {
  const auto& table = angle_tables.deg;
  const double scaled = AngleTables::steps * std::sqrt(std::clamp(1.0 - cosine, 0.0, 1.0));
  const auto lower = static_cast<std::size_t>(scaled);
  return table[lower] + (scaled - static_cast<double>(lower)) * (table[lower + 1] - table[lower]);
}

/// Cosine and sine of 2πu for u in [0, 1), to 4e-16: the nearest of 256 stored turns, turned on by
/// a series of the rest.
inline Turn turn(double u) {
  constexpr double turns = AngleTables::turns;
  const auto nearest = static_cast<std::size_t>(turns * u + 0.5);
  const Turn& at = angle_tables.turn[nearest];
  const double rest = 2.0 * optics::pi * (u - static_cast<double>(nearest) / turns);
  const double r2 = rest * rest;
  const double cosine = 1.0 - r2 * (1.0 / 2 - r2 * (1.0 / 24 - r2 / 720));
  const double sine = rest * (1.0 - r2 * (1.0 / 6 - r2 / 120));
  return {at.cosine * cosine - at.sine * sine, at.sine * cosine + at.cosine * sine};
}

}  // namespace umov::chamber
