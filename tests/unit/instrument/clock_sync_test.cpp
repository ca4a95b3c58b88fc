#include "host/instrument/clock_sync.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "host/errors/error.hpp"

namespace umov::instrument {
namespace {

constexpr std::uint64_t epoch_us = 1'700'000'000'000'000;

/// A device whose clock began at `epoch_us` and gains 30 µs a second.
std::uint64_t device_clock(double host_s) {
  return static_cast<std::uint64_t>(host_s * 1.00003e6);
}
std::uint64_t host_clock(double host_s) {
  return epoch_us + static_cast<std::uint64_t>(host_s * 1e6);
}

RoundTrip round_trip(double host_s, double there_s, double back_s) {
  return {host_clock(host_s), device_clock(host_s + there_s),
          device_clock(host_s + there_s + 20e-6), host_clock(host_s + there_s + 20e-6 + back_s)};
}

TEST(ClockSync, NothingIsKnownBeforeTheFirstRoundTrip) {
  const ClockSync clock;
  EXPECT_FALSE(clock.ready());
  EXPECT_THROW(clock.host_time_us(0), Error);
}

TEST(ClockSync, OneRoundTripGivesTheOffsetWithinHalfOfIt) {
  ClockSync clock;
  clock.add(round_trip(10.0, 300e-6, 100e-6));
  const double miss = clock.host_time_us(static_cast<double>(device_clock(10.0))) -
                      static_cast<double>(host_clock(10.0));
  EXPECT_NEAR(miss, -100.0, 2.0) << "half the asymmetry";
  const double u = clock.uncertainty_us(static_cast<double>(device_clock(10.0)));
  EXPECT_GE(u, 400.0 / std::sqrt(12.0));
  EXPECT_LE(u, 1.2 * 400.0 / std::sqrt(12.0));
}

TEST(ClockSync, SlowRoundTripsDoNotPullTheClock) {
  std::mt19937_64 random(8);
  ClockSync clock;
  for (int i = 0; i < 100; ++i) {
    const bool slow = random() % 3 != 0;
    const double queue_s = slow ? static_cast<double>(random() % 20000) * 1e-6 : 0;
    clock.add(round_trip(i, 100e-6 + queue_s, 100e-6));
  }
  EXPECT_NEAR(clock.rate(), 1 / 1.00003, 3e-7);
  EXPECT_NEAR(clock.fastest_us(), 200.0, 2.0);
  const double device_us = static_cast<double>(device_clock(99.5));
  EXPECT_NEAR(clock.host_time_us(device_us), static_cast<double>(host_clock(99.5)), 15.0);
}

TEST(ClockSync, TheStatedUncertaintyCoversTheMiss) {
  // 300 links with their own asymmetry: two thirds within one standard uncertainty or more.
  std::mt19937_64 random(9);
  int within_one = 0;
  int within_two = 0;
  for (int link = 0; link < 300; ++link) {
    ClockSync clock;
    const double there = static_cast<double>(random() % 1000) * 1e-6;
    const double back = 1000e-6 - there;
    for (int i = 0; i < 40; ++i) {
      clock.add(round_trip(i, there + static_cast<double>(random() % 100) * 1e-6,
                           back + static_cast<double>(random() % 100) * 1e-6));
    }
    const double device_us = static_cast<double>(device_clock(20.0));
    const double miss =
        std::abs(clock.host_time_us(device_us) - static_cast<double>(host_clock(20.0)));
    within_one += miss < clock.uncertainty_us(device_us) ? 1 : 0;
    within_two += miss < 2 * clock.uncertainty_us(device_us) ? 1 : 0;
  }
  EXPECT_GT(within_one, 150);
  EXPECT_EQ(within_two, 300);
}

TEST(ClockSync, ThePredictionLosesPrecisionWithDistance) {
  ClockSync clock;
  for (int i = 0; i < 3; ++i) clock.add(round_trip(0.1 * i, 100e-6, 100e-6));
  const double near = clock.uncertainty_us(static_cast<double>(device_clock(0.2)));
  const double far = clock.uncertainty_us(static_cast<double>(device_clock(100.2)));
  EXPECT_GT(far, near + 1000) << "100 s at a rate known to 100 ppm";
}

TEST(ClockSync, AClockThatWentBackIsIgnored) {
  ClockSync clock;
  clock.add({100, 50, 60, 90});
  clock.add({100, 60, 50, 190});
  EXPECT_FALSE(clock.ready());
}

}  // namespace
}  // namespace umov::instrument
