// The chopper with a drive of its own: edges, light, and what the plant makes of them.
#include "hil/plant/chopper.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

namespace umov::plant {
namespace {

constexpr double two_pi = 2.0 * std::numbers::pi;

TEST(Chopper, GivesAnEdgeATurnWhereTheLightComesOn) {
  const Chopper chopper({.frequency_hz = 437, .wander = 0.01, .wander_period_s = 0.5}, 1);
  double t = 0.2;
  for (int i = 0; i < 500; ++i) {
    const double next = chopper.next_edge_s(t);
    ASSERT_GT(next, t);
    if (i > 0) {
      ASSERT_NEAR(1 / (next - t), 437 * (1 + 0.01 * std::sin(two_pi * 0.5 * (t + next) / 0.5)),
                  0.01);
    }
    ASSERT_NEAR(std::remainder(chopper.turns(next), 1.0), 0.0, 1e-9);
    ASSERT_NEAR(chopper.opening(next), 0.0, 1e-6) << "half open";
    ASSERT_EQ(chopper.opening(next + 0.25 / 437), 1.0);
    ASSERT_EQ(chopper.opening(next - 0.25 / 437), -1.0);
    t = next;
  }
}

TEST(Chopper, EdgesJitterByAsMuchAsTold) {
  const Chopper chopper({.frequency_hz = 1000, .jitter_deg = 0.2}, 7);
  double squares = 0, t = 0;
  constexpr int count = 20'000;
  for (int i = 0; i < count; ++i) {
    t = chopper.next_edge_s(t);
    const double off = 360 * std::remainder(chopper.turns(t), 1.0);
    squares += off * off;
  }
  EXPECT_NEAR(std::sqrt(squares / count), 0.2, 0.004);
}

TEST(Chopper, StopsAndIsNotThereAtZero) {
  const Chopper chopper({.frequency_hz = 1000, .stops_s = 2}, 7);
  EXPECT_LT(chopper.next_edge_s(1.99), 2.0);
  EXPECT_TRUE(std::isinf(chopper.next_edge_s(1.9995)));
  EXPECT_EQ(chopper.opening(5), chopper.opening(50));
  EXPECT_FALSE(Chopper({}, 1).present());
  EXPECT_TRUE(std::isinf(Chopper({}, 1).next_edge_s(0)));
}

/// By its Fourier integral.
TEST(Chopper, FundamentalIsThatOfTheTrapezium) {
  for (const double share : {0.0, 0.05, 0.3}) {
    for (const double phase_deg : {0.0, 40.0}) {
      const Chopper chopper({.frequency_hz = 1, .edge_share = share, .phase_deg = phase_deg}, 1);
      std::complex<double> sum;
      constexpr int steps = 200'000;
      for (int i = 0; i < steps; ++i) {
        const double t = (i + 0.5) / steps;
        sum += chopper.opening(t) * std::polar(1.0, -two_pi * t) / double{steps};
      }
      // 2/π sin is the square wave's: c₁ = -2i/π.
      const auto expected = std::polar(2 / std::numbers::pi * chopper.fundamental(),
                                       (phase_deg - 90) * std::numbers::pi / 180);
      EXPECT_LT(std::abs(sum - expected), 1e-5) << share << " " << phase_deg;
    }
  }
}

}  // namespace
}  // namespace umov::plant
