// Limit switches met at full speed: the axis stands within the distance that its settings give.
#include "firmware/core/motion/stopping_distance.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/firmware/acceleration_end.hpp"
#include "tests/unit/firmware/bench.hpp"

namespace umov::test {
namespace {

struct Settings {
  double speed, acceleration, jerk;  // degrees, seconds
};

fw::AxisSettings axis_with(const Settings& s) {
  fw::AxisSettings axis = fw::default_axes[1];
  axis.speed_mdeg_s = static_cast<std::uint32_t>(std::lround(1000 * s.speed));
  axis.acceleration_mdeg_s2 = static_cast<std::uint32_t>(std::lround(1000 * s.acceleration));
  axis.jerk_mdeg_s3 = static_cast<std::uint32_t>(std::lround(1000 * s.jerk));
  return axis;
}

/// By integrating the acceleration that ends, then the ramp: jerk up, steady, jerk down.
double integrated_way_deg(const Settings& s) {
  const double peak = std::min(s.acceleration, std::sqrt(s.speed * s.jerk));
  const double turn_s = peak / s.jerk, whole_s = turn_s + s.speed / peak;
  double v = s.speed - peak * turn_s / 2, way = 0;
  constexpr int steps = 1'000'000;
  for (int i = 0; i < steps; ++i) {
    const double dt = turn_s / steps;
    const double a = peak - s.jerk * (i + 0.5) * dt;
    way += v * dt + 0.5 * a * dt * dt;
    v += a * dt;
  }
  for (int i = 0; i < steps; ++i) {
    const double t = (i + 0.5) * whole_s / steps;
    const double a = std::min({peak, s.jerk * t, s.jerk * (whole_s - t)});
    const double dt = whole_s / steps;
    way += v * dt - 0.5 * a * dt * dt;
    v -= a * dt;
  }
  return way;
}

TEST(StoppingDistance, IsTheRestOfTheAccelerationTheRampAndTheTimeUntilTheStop) {
  for (const Settings s : {Settings{40, 400, 8000}, Settings{360, 7200, 200'000},
                           Settings{10, 1200, 4000}, Settings{100, 200, 24'000}}) {
    const fw::AxisSettings axis = axis_with(s);
    const double found = 1e-6 * static_cast<double>(fw::stopping_distance_udeg(axis));
    EXPECT_NEAR(found, integrated_way_deg(s) + 2e-3 * s.speed + 1e-3, 1e-4);
  }
}

TEST(StoppingDistance, IsKeptByEveryStopAtALimit) {
  std::mt19937 random(11);
  double worst = 0;
  for (int i = 0; i < 150; ++i) {
    const auto within = [&](double low, double high) {
      return std::exp(std::uniform_real_distribution<>(std::log(low), std::log(high))(random));
    };
    const Settings s{within(1, 100), within(50, 2000), within(2'000, 100'000)};
    const fw::AxisSettings axis = axis_with(s);
    SmallWorld world;
    Bench bench(world);
    ASSERT_TRUE(bench.hello());
    ASSERT_TRUE(bench.home_all());
    ASSERT_TRUE(bench
                    .ask(pr::SetAxis{.axis = 1,
                                     .min_udeg = axis.min_udeg,
                                     .max_udeg = axis.max_udeg,
                                     .speed_mdeg_s = axis.speed_mdeg_s,
                                     .acceleration_mdeg_s2 = axis.acceleration_mdeg_s2,
                                     .jerk_mdeg_s3 = axis.jerk_mdeg_s3,
                                     .take_up_udeg = 0})
                    .has_value());
    // In turn in the middle of the way, and at the end of the acceleration or up to 2 ms before.
    const std::int32_t end = acceleration_end(axis, 89'000);
    const double early_steps = within(0.01, 2) * s.speed;
    world.upper[1] = i % 2 == 0 ? 45'000 : std::max(1, end - static_cast<int>(early_steps));
    ASSERT_TRUE(bench.ask(pr::Move{.axis = 1, .target_udeg = 89'000'000}).has_value());
    for (int wait = 0; wait < 2000 && bench.fault() == pr::Fault::none; ++wait) {
      bench.board.run_for(100'000);
    }
    ASSERT_EQ(bench.fault(), pr::Fault::limit);
    for (int wait = 0; wait < 40; ++wait) {
      bench.board.run_for(100'000);
      bench.status();
    }
    const double way = 1e3 * (world.position[1] - world.upper[1]);
    const auto allowed = static_cast<double>(fw::stopping_distance_udeg(axis));
    worst = std::max(worst, way / allowed);
    EXPECT_LE(way, allowed) << s.speed << " " << s.acceleration << " " << s.jerk;
  }
  std::printf("at most %.4f of the stopping distance\n", worst);
  EXPECT_GT(worst, 0.95) << "no more room is asked for than is used";
}

}  // namespace
}  // namespace umov::test
