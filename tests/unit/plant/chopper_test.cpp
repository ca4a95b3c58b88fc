// The chopper with a drive of its own: edges, light, and what the plant makes of them.
#include "hil/plant/chopper.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include "hil/plant/plant.hpp"
#include "hil/plant/sample_catalog.hpp"

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

/// The light that the chopper lets pass, detected in floating point over whole turns.
TEST(Chopper, LightOfThePlantIsTheOneExpected) {
  PlantConfig config = ideal_config();
  config.chopper = {.frequency_hz = 437, .edge_share = 0.1, .phase_deg = 25};
  const Chopper chopper(config.chopper, 0);
  Plant plant({.config = config, .sample = make_sample("lambertian-99")});
  plant.set_laser(1, true, 0.0);
  plant.set_shutter(true, 0.0);
  plant.set_gain(2, 0.0);
  plant.set_reference(0);
  constexpr std::size_t count = 100'000;  // 437 turns
  std::vector<std::uint16_t> signal(count), monitor(count);
  plant.sample(0.0, 100e3, 0, signal, monitor);
  std::complex<double> x, m;
  for (std::size_t i = 0; i < count; ++i) {
    const auto reference =
        std::polar(2.0 / count, two_pi * (0.25 - chopper.turns(static_cast<double>(i) / 100e3)));
    x += (signal[i] - 2048.0) * reference;
    m += (monitor[i] - 2048.0) * reference;
  }
  const double volts = config.adc.full_scale_v / 4096;
  const ExpectedSignal expected = plant.expected(0.5);
  EXPECT_NEAR(volts * x.real() / 100, expected.x_v, 1e-4 * expected.x_v);
  EXPECT_NEAR(volts * x.imag() / 100, expected.y_v, 1e-4 * expected.x_v);
  EXPECT_NEAR(volts * m.real(), expected.monitor_v, 1e-4 * expected.monitor_v);
}

}  // namespace
}  // namespace umov::plant
