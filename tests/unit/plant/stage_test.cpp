#include "hil/plant/stage.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "bench.hpp"

namespace umov::plant {
namespace {

TEST(HomeSwitch, IsPressedBelowItsEdgeAndReleasedOnIt) {
  AxisTravel travel{.steps_per_turn = 3600, .home_deg = 10.0, .start_deg = 10.0};
  Stage stage(travel, {}, 1);
  EXPECT_FALSE(stage.switches().home);
  stage.step(-1);
  EXPECT_TRUE(stage.switches().home);
  stage.step(+1);
  EXPECT_FALSE(stage.switches().home);
  EXPECT_DOUBLE_EQ(stage.true_deg(), 10.0);
}

TEST(LimitSwitches, PressAtAndBeyondTheirAngles) {
  AxisTravel travel{.steps_per_turn = 360, .lower_limit_deg = -5.0, .upper_limit_deg = 7.0};
  Stage stage(travel, {}, 1);
  for (int i = 0; i < 6; ++i) stage.step(+1);
  EXPECT_FALSE(stage.switches().upper_limit);
  stage.step(+1);
  EXPECT_TRUE(stage.switches().upper_limit);
  stage.step(+1);
  EXPECT_TRUE(stage.switches().upper_limit);
  for (int i = 0; i < 13; ++i) stage.step(-1);
  EXPECT_TRUE(stage.switches().lower_limit);
  EXPECT_FALSE(stage.switches().upper_limit);
}

TEST(Switches, SitOnTheDriveSoThatPlayDoesNotShiftTheZero) {
  AxisErrors errors;
  errors.backlash_deg = 1.0;
  AxisTravel travel{.steps_per_turn = 3600, .start_deg = 3.0};
  Stage stage(travel, errors, 1);
  int steps = 0;
  while (!stage.switches().home) {
    stage.step(-1);
    ++steps;
  }
  EXPECT_EQ(steps, 31);  // 30 to the edge and one past it
  EXPECT_NEAR(stage.true_deg(), stage.motor_deg() + 0.5, 1e-12);
}

TEST(GearError, HasFourCyclesAMotorTurn) {
  AxisErrors errors;
  errors.gear_deg = 0.0118;
  errors.gear_ratio = 180.0;
  errors.gear_phase_deg = 30.0;
  AxisTravel travel{.steps_per_turn = 320'000};
  Stage stage(travel, errors, 1);
  const double start = stage.true_deg() - stage.motor_deg();
  EXPECT_NEAR(start, 0.0118 * 0.5, 1e-12);
  // A quarter of a motor turn is a whole cycle: 360°/180/4 = 0.5°, not a whole number of steps, so
  // compare with the sine itself.
  int crossings = 0;
  double previous = start;
  for (int i = 0; i < 320'000 / 180; ++i) {
    stage.step(+1);
    const double error = stage.true_deg() - stage.motor_deg();
    crossings += previous < 0.0 && error >= 0.0;
    EXPECT_NEAR(error, 0.0118 * std::sin(optics::radians(4.0 * 180.0 * stage.motor_deg() + 30.0)),
                1e-9);
    previous = error;
  }
  EXPECT_EQ(crossings, 4);
}

TEST(Standstill, IsDrawnAnewAtEachArrivalAndHasItsRms) {
  AxisErrors errors;
  errors.standstill_deg = 0.01;
  Stage stage({}, errors, 99);
  double sum = 0, squares = 0;
  constexpr int n = 4000;
  for (int i = 0; i < n; ++i) {
    stage.step(i % 2 == 0 ? 1 : -1);
    const double error = stage.true_deg() - stage.motor_deg();
    EXPECT_EQ(error, stage.true_deg() - stage.motor_deg());
    sum += error;
    squares += error * error;
  }
  EXPECT_NEAR(sum / n, 0.0, 5 * 0.01 / std::sqrt(n));
  EXPECT_NEAR(std::sqrt(squares / n), 0.01, 5 * 0.01 / std::sqrt(2.0 * n));
}

TEST(Parking, TakesPolariserAndAnalyserOutOfTheBeam) {
  test::Bench bench(ideal_config(), "lambertian-99");
  bench.laser(1);
  bench.geometry(0, 0);
  bench.polarization(0, 0);
  const auto both = bench.plant().expected(20.0);
  bench.polarization(test::open, 0);
  const auto analyser_only = bench.plant().expected(20.0);
  bench.polarization(test::open, test::open);
  const auto none = bench.plant().expected(20.0);
  EXPECT_NEAR(analyser_only.monitor_v, 2.0 * both.monitor_v, 1e-12);
  EXPECT_NEAR(analyser_only.x_v, 2.0 * both.x_v, 1e-12);
  EXPECT_NEAR(none.x_v, 2.0 * analyser_only.x_v, 1e-12);
}

}  // namespace
}  // namespace umov::plant
