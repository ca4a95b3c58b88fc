#include <gtest/gtest.h>

#include "firmware/core/motion/profile.hpp"
#include "tests/unit/firmware/bench.hpp"

namespace umov::test {
namespace {

constexpr int detector = 1;
constexpr int azimuth = 2;
constexpr std::int32_t degree = 1'000'000;

TEST(Homing, FindsTheEdgeFromAboveFromBelowAndOnAPressedSwitch) {
  for (const bool narrow : {false, true}) {
    for (const std::int32_t start : {-70'000, -20'000, -300, -1, 0, 1, 250, 40'000, 79'000}) {
      SmallWorld world;
      // A flag of 0.7 degrees, or everything below the edge.
      if (narrow) world.home_width.fill(620);
      world.position.fill(0);
      world.position[detector] = start;
      Bench bench(world);
      ASSERT_TRUE(bench.hello());
      ASSERT_TRUE(bench.ask(pr::Home{1u << detector}));
      ASSERT_TRUE(bench.wait_for(pr::State::idle, 60)) << start;
      EXPECT_EQ(bench.status().homed_mask, 1u << detector);
      EXPECT_EQ(world.position[detector], 0) << "from " << start << (narrow ? " flag" : " wide");
      EXPECT_EQ(bench.board.position_steps(detector), 0);
    }
  }
}

TEST(Homing, LatchesNotHomedWhenTheSwitchIsNowhere) {
  SmallWorld world;
  world.home_width.fill(0);
  Bench bench(world);
  ASSERT_TRUE(bench.hello());
  ASSERT_TRUE(bench.ask(pr::Home{1u << detector}));
  ASSERT_TRUE(bench.wait_for(pr::State::safe, 60));
  EXPECT_EQ(bench.fault(), pr::Fault::not_homed);
  ASSERT_EQ(bench.heard.faults.size(), 1u);
  EXPECT_EQ(bench.heard.faults[0].detail, detector);
  EXPECT_EQ(bench.status().homed_mask, 0);
}

TEST(Motion, ArrivesExactlyOnRandomTargetsWithNoStepLost) {
  SmallWorld world;
  Bench bench(world);
  ASSERT_TRUE(bench.hello());
  ASSERT_TRUE(bench.home_all());
  std::mt19937 random(8);
  for (int i = 0; i < 60; ++i) {
    const auto axis = static_cast<std::uint8_t>(random() % 6);
    const auto& s = fw::default_axes[axis];
    std::int32_t target =
        std::uniform_int_distribution<std::int32_t>(s.min_udeg, s.max_udeg)(random);
    if (s.open_udeg != 0 && i % 3 == 0) target = pr::open_position;
    ASSERT_TRUE(bench.ask(pr::Move{axis, target}));
    ASSERT_TRUE(bench.wait_for(pr::State::idle, 60));
    const std::int32_t angle = target == pr::open_position ? s.open_udeg : target;
    ASSERT_EQ(world.position[axis], fw::steps_from_udeg(angle, s.steps_per_turn));
    ASSERT_NEAR(bench.status().position_udeg[axis], angle, 180e6 / s.steps_per_turn + 1);
  }
}

TEST(Motion, TakesTheTimeTheDesignAsksFor) {
  SmallWorld world;
  Bench bench(world);
  ASSERT_TRUE(bench.hello());
  ASSERT_TRUE(bench.home_all());
  const std::uint64_t start = bench.board.now_us();
  ASSERT_TRUE(bench.ask(pr::Move{detector, 2 * degree}));
  while (bench.state() == pr::State::moving) bench.board.run_for(1000);
  EXPECT_NEAR(static_cast<double>(bench.board.now_us() - start), 200'000, 20'000);
}

TEST(Motion, MakesStepEdgesOnTheTicksOfTheProfile) {
  SmallWorld world;
  Bench bench(world);
  ASSERT_TRUE(bench.hello());
  ASSERT_TRUE(bench.home_all());
  world.log_axis = detector;
  ASSERT_TRUE(bench.ask(pr::Move{detector, 20 * degree}));
  ASSERT_TRUE(bench.wait_for(pr::State::idle, 60));
  const auto& s = fw::default_axes[detector];
  const fw::Profile profile(
      20'000,
      fw::motion_limits(s.steps_per_turn, s.speed_mdeg_s, s.acceleration_mdeg_s2, s.jerk_mdeg_s3),
      fw::step_timer_hz);
  ASSERT_EQ(world.step_times.size(), 20'000u);
  const double begin =
      world.step_times[0] - static_cast<double>(profile.step_tick(1, 0)) / fw::step_timer_hz;
  double worst = 0;
  for (std::uint32_t k = 1; k <= 20'000; ++k) {
    const double due =
        static_cast<double>(profile.step_tick(k, profile.total_ticks() / 3)) / fw::step_timer_hz;
    worst = std::max(worst, std::fabs(world.step_times[k - 1] - begin - due));
  }
  EXPECT_LE(worst * fw::step_timer_hz, 1.01);
}

TEST(Motion, ComesToAControlledStopAndStillKnowsWhereItIs) {
  const auto& s = fw::default_axes[detector];
  std::mt19937 random(4);
  for (int i = 0; i < 20; ++i) {
    SmallWorld world;
    Bench bench(world);
    ASSERT_TRUE(bench.hello());
    ASSERT_TRUE(bench.home_all());
    world.log_axis = detector;
    ASSERT_TRUE(bench.ask(pr::Move{detector, 60 * degree}));
    const std::uint64_t run_us = random() % 1'400'000;
    bench.board.run_for(run_us);
    const double asked_at = static_cast<double>(bench.board.now_us()) * 1e-6;
    ASSERT_TRUE(bench.ask(pr::Stop{0}));
    ASSERT_TRUE(bench.wait_for(pr::State::idle, 5));
    ASSERT_EQ(bench.board.position_steps(detector), world.position[detector]);
    ASSERT_LT(world.position[detector], fw::steps_from_udeg(60 * degree, s.steps_per_turn));
    // Speed and acceleration from the edges themselves, over 20 steps: no step is made faster than
    // the limit, and the speed never jumps.
    const auto& t = world.step_times;
    const double steps_per_deg = s.steps_per_turn / 360.0;
    double speed_before = -1, time_before = 0;
    for (std::size_t k = 20; k < t.size(); k += 20) {
      const double speed = 20 / (t[k] - t[k - 20]) / steps_per_deg;
      const double time = (t[k] + t[k - 20]) / 2;
      ASSERT_LE(speed, s.speed_mdeg_s * 1e-3 * 1.001);
      if (speed_before >= 0 && time - time_before > 1e-4) {
        ASSERT_LE(std::fabs(speed - speed_before) / (time - time_before),
                  s.acceleration_mdeg_s2 * 1e-3 * 1.1 + 5);
      }
      speed_before = speed;
      time_before = time;
    }
    // v/a + a/j = 0.15 s from top speed, and as much again while still accelerating.
    if (!t.empty()) {
      ASSERT_LT(t.back(), asked_at + 0.22);
    }
    // A second move starts from there and arrives exactly.
    ASSERT_TRUE(bench.ask(pr::Move{detector, -3 * degree}));
    ASSERT_TRUE(bench.wait_for(pr::State::idle, 10));
    ASSERT_EQ(world.position[detector], fw::steps_from_udeg(-3 * degree, s.steps_per_turn));
  }
}

TEST(Motion, RefusesTargetsBeyondTheSoftLimitsAndAxesNotHomed) {
  SmallWorld world;
  Bench bench(world);
  ASSERT_TRUE(bench.hello());
  EXPECT_EQ(bench.refusal_of(pr::Move{detector, 0}), pr::Refusal::not_homed);
  ASSERT_TRUE(bench.home_all());
  EXPECT_EQ(bench.refusal_of(pr::Move{detector, 90 * degree + 1}), pr::Refusal::outside_limits);
  EXPECT_EQ(bench.refusal_of(pr::Move{detector, -90 * degree - 1}), pr::Refusal::outside_limits);
  EXPECT_EQ(bench.refusal_of(pr::Move{detector, pr::open_position}), pr::Refusal::outside_limits);
  EXPECT_EQ(bench.refusal_of(pr::Move{3, pr::open_position}), pr::Refusal::none);
}

TEST(Motion, DeceleratesAtALimitSwitchLatchesAFaultAndCanBeMovedAway) {
  SmallWorld world;
  Bench bench(world);
  ASSERT_TRUE(bench.hello());
  ASSERT_TRUE(bench.home_all());
  world.upper[detector] = fw::steps_from_udeg(30 * degree, 360'000);
  ASSERT_TRUE(bench.ask(pr::Move{detector, 60 * degree}));
  ASSERT_TRUE(bench.wait_for(pr::State::safe, 10));
  bench.board.run_for(400'000);
  EXPECT_EQ(bench.fault(), pr::Fault::limit);
  ASSERT_EQ(bench.heard.faults.size(), 1u);
  EXPECT_EQ(bench.heard.faults[0].detail, detector);
  EXPECT_GT(world.position[detector], world.upper[detector]);
  // v^2 / 2a + v a / 2j = 2 + 1 degrees, and the tick in which it is planned.
  EXPECT_LT(world.position[detector], fw::steps_from_udeg(33'200'000, 360'000));
  EXPECT_EQ(bench.board.position_steps(detector), world.position[detector]);
  EXPECT_EQ(bench.refusal_of(pr::Move{detector, 0}), pr::Refusal::fault_active);
  EXPECT_EQ(bench.refusal_of(pr::Home{2}), pr::Refusal::fault_active);
  ASSERT_TRUE(bench.ask(pr::ClearFault{static_cast<std::uint8_t>(pr::Fault::limit)}));
  // Further into the switch: not a step.
  const auto there = world.position[detector];
  ASSERT_TRUE(bench.ask(pr::Move{detector, 61 * degree}));
  ASSERT_TRUE(bench.wait_for(pr::State::safe, 1));
  EXPECT_EQ(world.position[detector], there);
  ASSERT_TRUE(bench.ask(pr::ClearFault{static_cast<std::uint8_t>(pr::Fault::limit)}));
  ASSERT_TRUE(bench.ask(pr::Move{detector, 5 * degree}));
  ASSERT_TRUE(bench.wait_for(pr::State::idle, 10));
  EXPECT_EQ(world.position[detector], fw::steps_from_udeg(5 * degree, 360'000));
}

TEST(Motion, ArrivesAlwaysFromBelowWhenTakeUpIsOn) {
  SmallWorld world;
  Bench bench(world);
  ASSERT_TRUE(bench.hello());
  ASSERT_TRUE(bench.home_all());
  const auto& s = fw::default_axes[azimuth];
  ASSERT_TRUE(bench.ask(pr::SetAxis{azimuth, s.min_udeg, s.max_udeg, s.speed_mdeg_s,
                                    s.acceleration_mdeg_s2, s.jerk_mdeg_s3, 500'000}));
  ASSERT_TRUE(bench.ask(pr::Move{azimuth, 20 * degree}));
  ASSERT_TRUE(bench.wait_for(pr::State::idle, 10));
  const std::int64_t steps = world.steps[azimuth];
  ASSERT_TRUE(bench.ask(pr::Move{azimuth, 10 * degree}));
  ASSERT_TRUE(bench.wait_for(pr::State::idle, 10));
  EXPECT_EQ(world.position[azimuth], fw::steps_from_udeg(10 * degree, s.steps_per_turn));
  const std::int32_t take_up = fw::steps_from_udeg(500'000, s.steps_per_turn);
  const std::int32_t distance = fw::steps_from_udeg(20 * degree, s.steps_per_turn) -
                                fw::steps_from_udeg(10 * degree, s.steps_per_turn);
  EXPECT_EQ(world.steps[azimuth] - steps, distance + 2 * take_up);
  EXPECT_EQ(bench.refusal_of(pr::SetAxis{azimuth, s.min_udeg, s.max_udeg, s.speed_mdeg_s,
                                         s.acceleration_mdeg_s2, s.jerk_mdeg_s3, 3'000'000}),
            pr::Refusal::out_of_range);
}

TEST(Motion, RefusesSettingsTheStepTimerCannotFollow) {
  SmallWorld world;
  Bench bench(world);
  ASSERT_TRUE(bench.hello());
  const auto& s = fw::default_axes[detector];
  pr::SetAxis change{detector,       s.min_udeg, s.max_udeg, 720'000, s.acceleration_mdeg_s2,
                     s.jerk_mdeg_s3, 0};
  EXPECT_EQ(bench.refusal_of(change), pr::Refusal::out_of_range);  // 720,000 steps/s
  change.speed_mdeg_s = 480'000;
  EXPECT_EQ(bench.refusal_of(change), pr::Refusal::none);
  const auto info = bench.ask(pr::GetAxis{detector});
  ASSERT_TRUE(info);
  EXPECT_EQ(info->speed_mdeg_s, 480'000u);
  change.min_udeg = change.max_udeg;
  EXPECT_EQ(bench.refusal_of(change), pr::Refusal::out_of_range);
}

}  // namespace
}  // namespace umov::test
