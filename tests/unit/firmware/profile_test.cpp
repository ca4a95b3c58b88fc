#include "firmware/core/motion/profile.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <random>
#include <vector>

#include "firmware/core/config/axis_settings.hpp"
#include "firmware/core/config/design_parameters.hpp"
#include "firmware/core/integer/wide.hpp"

namespace umov::firmware {
namespace {

/// The profile in long double, from its durations only.
struct Ideal {
  long double t1, t2, t3, distance, jerk;
  Ideal(const SegmentTicks& d, long double total_distance)
      : t1(static_cast<long double>(d.jerk)),
        t2(static_cast<long double>(d.acceleration)),
        t3(static_cast<long double>(d.cruise)),
        distance(total_distance),
        jerk(total_distance / (t1 * (t1 + t2) * (2 * t1 + t2 + t3))) {}
  long double total() const { return 4 * t1 + 2 * t2 + t3; }
  long double at(long double t) const {
    if (t > total() / 2) return distance - at(total() - t);
    const long double a = jerk * t1;
    if (t <= t1) return jerk * t * t * t / 6;
    const long double s1 = a * t1 * t1 / 6, v1 = a * t1 / 2;
    if (t <= t1 + t2) return s1 + v1 * (t - t1) + a * (t - t1) * (t - t1) / 2;
    const long double v2 = v1 + a * t2, s2 = s1 + v1 * t2 + a * t2 * t2 / 2;
    const long double u = t - t1 - t2;
    if (u <= t1) return s2 + v2 * u + a * u * u / 2 - jerk * u * u * u / 6;
    const long double s3 = s2 + v2 * t1 + a * t1 * t1 / 3;
    return s3 + (v2 + a * t1 / 2) * (u - t1);
  }
  /// Time at which the distance is reached, by bisection.
  long double when(long double s) const {
    long double low = 0, high = total();
    for (int i = 0; i < 90; ++i) {
      const long double middle = (low + high) / 2;
      (at(middle) < s ? low : high) = middle;
    }
    return low;
  }
};

struct Case {
  std::uint32_t steps, steps_per_turn, speed, acceleration, jerk;
};

Case random_case(std::mt19937_64& random) {
  const auto log_uniform = [&](double low, double high) {
    return std::exp(std::uniform_real_distribution<>(std::log(low), std::log(high))(random));
  };
  return {static_cast<std::uint32_t>(log_uniform(1, 400'000)),
          static_cast<std::uint32_t>(log_uniform(3'000, 400'000)),
          static_cast<std::uint32_t>(log_uniform(100, 400'000)),
          static_cast<std::uint32_t>(log_uniform(1'000, 20'000'000)),
          static_cast<std::uint32_t>(log_uniform(10'000, 2'000'000'000))};
}

Profile profile_of(const Case& c) {
  return {c.steps, motion_limits(c.steps_per_turn, c.speed, c.acceleration, c.jerk), step_timer_hz};
}

TEST(Profile, KeepsSpeedAccelerationAndJerkWithinTheirLimitsForAnyMove) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 3000; ++i) {
    const Case c = random_case(random);
    const Profile p = profile_of(c);
    const SegmentTicks& d = p.durations();
    const long double f = step_timer_hz, per_mdeg = c.steps_per_turn / 360'000.0L;
    const long double u = static_cast<long double>(d.jerk + d.acceleration);
    const long double s = u + static_cast<long double>(d.jerk + d.cruise);
    const long double speed = c.steps / s * f, acceleration = c.steps / (u * s) * f * f;
    const long double jerk = c.steps / (u * s * static_cast<long double>(d.jerk)) * f * f * f;
    ASSERT_LE(speed, c.speed * per_mdeg * (1 + 1e-12L));
    ASSERT_LE(acceleration, c.acceleration * per_mdeg * (1 + 1e-12L));
    ASSERT_LE(jerk, c.jerk * per_mdeg * (1 + 1e-12L));
    ASSERT_EQ(p.steps(), c.steps);
  }
}

TEST(Profile, TakesNoLongerThanTheTimeOptimalMoveButForRounding) {
  // Durations of the continuous problem: v, a and j reached as far as the distance allows.
  std::mt19937_64 random(2);
  for (int i = 0; i < 3000; ++i) {
    const Case c = random_case(random);
    const double per = c.steps_per_turn / 360'000.0;
    const double v = c.speed * per, a = c.acceleration * per, j = c.jerk * per, d = c.steps;
    const double t1 = std::min({std::cbrt(d / (2 * j)), std::sqrt(v / j), a / j});
    const double a1 = j * t1;
    double t2 = (-3 * t1 + std::sqrt(t1 * t1 + 4 * d / a1)) / 2;
    t2 = std::max(0.0, std::min(t2, v / a1 - t1));
    const double t3 = std::max(0.0, d / (a1 * (t1 + t2)) - 2 * t1 - t2);
    const double best = 4 * t1 + 2 * t2 + t3;
    const double have = static_cast<double>(profile_of(c).total_ticks()) / step_timer_hz;
    ASSERT_GE(have, best * (1 - 1e-9));
    // Longer durations in whole ticks cost a few ticks each; relative for very short jerk phases.
    ASSERT_LE(have, best + 12.0 / step_timer_hz + best * 3.0 / (t1 * step_timer_hz))
        << c.steps << " " << c.speed << " " << c.acceleration << " " << c.jerk;
  }
}

TEST(Profile, MakesEveryStepWithinATickOfTheIdealProfile) {
  std::mt19937_64 random(3);
  long double worst = 0;
  for (int i = 0; i < 400; ++i) {
    const Case c = random_case(random);
    const Profile p = profile_of(c);
    const Ideal ideal(p.durations(), c.steps);
    std::uint64_t tick = p.total_ticks(), before = 0, interval = 0;
    for (std::uint32_t k = 1; k <= std::min(c.steps, 200u); ++k) {
      tick = p.step_tick(k, k == 1 ? tick : before + interval);
      worst = std::max(worst, std::fabs(static_cast<long double>(tick) - ideal.when(k - 0.5L)));
      interval = tick - before;
      before = tick;
    }
    for (int n = 0; n < 100; ++n) {
      const auto k = 1 + static_cast<std::uint32_t>(random() % c.steps);
      tick = p.step_tick(k, random() % p.total_ticks());  // any guess will do
      worst = std::max(worst, std::fabs(static_cast<long double>(tick) - ideal.when(k - 0.5L)));
    }
  }
  EXPECT_LT(worst, 1.0L);
  std::printf("worst step edge: %.3Lf ticks from the ideal\n", worst);
}

TEST(Profile, MakesStepsAtIncreasingTimesAndEndsAfterTheLastOne) {
  const Profile p(17'000, motion_limits(320'000, 40'000, 400'000, 8'000'000), step_timer_hz);
  std::uint64_t before = 0, guess = p.total_ticks(), interval = 0;
  for (std::uint32_t k = 1; k <= 17'000; ++k) {
    const std::uint64_t tick = p.step_tick(k, guess);
    ASSERT_GE(tick, before + (k == 1 ? 1 : shortest_step_ticks));
    interval = tick - before;
    before = tick;
    guess = tick + interval;
  }
  EXPECT_LE(before, p.total_ticks());
}

TEST(Profile, HandlesASingleStep) {
  const Profile p(1, motion_limits(320'000, 40'000, 400'000, 8'000'000), step_timer_hz);
  EXPECT_EQ(p.steps(), 1u);
  EXPECT_EQ(p.step_tick(1, p.total_ticks()), p.total_ticks() / 2);
}

TEST(Profile, StopsUnderControlFromAnyInstantWithoutTouchingThePast) {
  std::mt19937_64 random(4);
  for (int i = 0; i < 1500; ++i) {
    const Case c = random_case(random);
    const Profile p = profile_of(c);
    const std::uint64_t at = random() % p.total_ticks();
    const Profile stop = p.stopped_after(at);
    const SegmentTicks &d = p.durations(), &n = stop.durations();
    ASSERT_LE(stop.total_ticks(), p.total_ticks());
    ASSERT_LE(n.jerk, d.jerk);
    // Same jerk, so the same trajectory until the branch, and limits kept after it.
    const long double total = static_cast<long double>(p.distance_at(p.total_ticks()));
    const long double u = static_cast<long double>(d.jerk + d.acceleration);
    const long double jerk = total / (static_cast<long double>(d.jerk) * u *
                                      (u + static_cast<long double>(d.jerk + d.cruise)));
    const long double un = static_cast<long double>(n.jerk + n.acceleration);
    const long double jerk_n = static_cast<long double>(stop.distance_at(stop.total_ticks())) /
                               (static_cast<long double>(n.jerk) * un *
                                (un + static_cast<long double>(n.jerk + n.cruise)));
    const std::uint64_t early = at > 0 ? random() % at : 0;
    const std::uint64_t had = p.distance_at(early), has = stop.distance_at(early);
    ASSERT_NEAR(static_cast<double>(had), static_cast<double>(has),
                200 + 1e-9 * static_cast<double>(had));
    if (n.jerk > 50) {
      ASSERT_NEAR(static_cast<double>(jerk_n / jerk), 1.0, 1e-3);
    }
    // From here on at most a full ramp: the braking is over within the time of the ramp before.
    ASSERT_LE(stop.total_ticks(),
              at + std::max<std::uint64_t>(at, 1) + 2 * n.jerk + n.acceleration + 4);
  }
}

TEST(WideIntegers, AgreeWithTheCompilersOwn) {
  std::mt19937_64 random(6);
  using Wide = unsigned __int128;
  const auto wide = [](const Uint128& a) { return (Wide{a.high} << 64) | a.low; };
  const auto any = [&] { return random() >> (random() % 64); };
  for (int i = 0; i < 100'000; ++i) {
    const std::uint64_t a = any(), b = any(), c = any() | 1u;
    const Uint128 product = multiply(a, b);
    ASSERT_TRUE(wide(product) == Wide{a} * b);
    ASSERT_TRUE(wide(divide(product, c)) == Wide{a} * b / c);
    ASSERT_TRUE(wide(divide_up(product, c)) == (Wide{a} * b + c - 1) / c);
    ASSERT_TRUE(wide(product + Uint128{c}) == Wide{a} * b + c);
    const unsigned shift = static_cast<unsigned>(random() % 64);
    ASSERT_TRUE(multiply_shift(a, b, shift) == static_cast<std::uint64_t>((Wide{a} * b) >> shift));
    const Wide root = square_root(product);
    ASSERT_TRUE(root * root <= wide(product));
    // 2^64 squared is 0 in 128 bits: then the root is the largest there is.
    ASSERT_TRUE((root + 1) * (root + 1) > wide(product) || root == UINT64_MAX);
    const Uint128 small = product >> 4;
    const Wide up = square_root_up(small);
    ASSERT_TRUE(up * up >= wide(small) && (up == 0 || (up - 1) * (up - 1) < wide(small)));
    const Wide cube = cube_root_up(small);
    ASSERT_TRUE(cube * cube * cube >= wide(small));
    ASSERT_TRUE(cube == 0 || (cube - 1) * (cube - 1) * (cube - 1) < wide(small));
  }
}

TEST(Units, RoundAnglesToTheNearestStepAndBack) {
  EXPECT_EQ(steps_from_udeg(0, 320'000), 0);
  EXPECT_EQ(steps_from_udeg(90'000'000, 320'000), 80'000);
  EXPECT_EQ(steps_from_udeg(-90'000'000, 320'000), -80'000);
  EXPECT_EQ(steps_from_udeg(563, 320'000), 1);  // half a step is 562.5 udeg
  EXPECT_EQ(steps_from_udeg(562, 320'000), 0);
  EXPECT_EQ(steps_from_udeg(-563, 320'000), -1);
  EXPECT_EQ(steps_from_udeg(2'000'000'000, 320'000), 1'777'778);
  for (std::int32_t steps = -80'000; steps <= 80'000; steps += 37) {
    ASSERT_EQ(steps_from_udeg(udeg_from_steps(steps, 320'000), 320'000), steps);
  }
}

}  // namespace
}  // namespace umov::firmware
