#include "host/chamber/fast_angle.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace umov::chamber {
namespace {

TEST(FastAngle, TurnsAndAnglesAreAsGoodAsTheySay) {
  constexpr int steps = 100'003;
  double turn_off = 0.0;
  double angle_off = 0.0;
  for (int i = 0; i < steps; ++i) {
    const double u = static_cast<double>(i) / steps;
    const double phi = 2.0 * optics::pi * u;
    const Turn t = turn(u);
    turn_off =
        std::max({turn_off, std::abs(t.cosine - std::cos(phi)), std::abs(t.sine - std::sin(phi))});
    angle_off = std::max(angle_off, std::abs(angle_deg(u) - optics::degrees(std::acos(u))));
  }
  EXPECT_LT(turn_off, 1e-15);  // 2πu itself is rounded by 4e-16
  EXPECT_LT(angle_off, 1e-4);
}

}  // namespace
}  // namespace umov::chamber
