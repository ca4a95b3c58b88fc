// The step pins of the emulated board against the profile that was asked for: every edge on its
// tick, also fast and on several axes at once; and what that costs.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <vector>

#include "firmware/core/config/axis_settings.hpp"
#include "firmware/core/config/design_parameters.hpp"
#include "firmware/core/motion/profile.hpp"
#include "hil/mcu/board/mcu_board.hpp"
#include "tests/unit/mcu_board/noisy_stages.hpp"
#include "tests/unit/mcu_board/scan_run.hpp"

namespace umov {
namespace {

constexpr mcu::Time tick = mcu::time_per_second / firmware::step_timer_hz;

class StepEdges : public testing::Test {
 protected:
  void SetUp() override {
    session_ = std::make_unique<instrument::Session>(test::connect(board_));
    test::home_all(*session_);
  }
  void set_speed(int axis, std::uint32_t speed_mdeg_s, std::uint32_t acceleration_mdeg_s2,
                 std::uint32_t jerk_mdeg_s3) {
    const auto& s = firmware::default_axes[static_cast<std::size_t>(axis)];
    session_->request(protocol::SetAxis{.axis = static_cast<std::uint8_t>(axis),
                                        .min_udeg = s.min_udeg,
                                        .max_udeg = s.max_udeg,
                                        .speed_mdeg_s = speed_mdeg_s,
                                        .acceleration_mdeg_s2 = acceleration_mdeg_s2,
                                        .jerk_mdeg_s3 = jerk_mdeg_s3,
                                        .take_up_udeg = 0});
    limits_[axis] =
        firmware::motion_limits(s.steps_per_turn, speed_mdeg_s, acceleration_mdeg_s2, jerk_mdeg_s3);
  }
  /// One row that moves these axes from 0 to these angles; measures nothing worth keeping.
  void move(const std::map<int, double>& degrees) {
    edges_.clear();
    protocol::ProgramRow row{
        .index = 0, .target_udeg = {}, .laser = 0, .shutter_open = 0, .gain = 0, .dwell_ms = 1};
    for (const auto& [axis, angle] : degrees)
      row.target_udeg[static_cast<std::size_t>(axis)] = static_cast<std::int32_t>(angle * 1e6);
    test::Records records;
    instrument::ProgramStream stream(
        {.program_id = ++program_, .row_count = 1}, [&](std::uint32_t) { return row; }, records);
    const std::uint64_t instructions = interrupt_instructions();
    stream.run(*session_);
    spent_ = interrupt_instructions() - instructions;
  }
  std::uint64_t interrupt_instructions() const {
    constexpr int tim2 = 16 + 28, tim5 = 16 + 50;
    return board_.chip().instructions_in(tim2) + board_.chip().instructions_in(tim5);
  }
  /// How far the edges of an axis are from the moments at which its profile, a cubic curve, is half
  /// a step on, counted from the first edge: the largest of all, in ticks of the step clock.
  double worst_edge_ticks(int axis, double degrees) {
    const auto& s = firmware::default_axes[static_cast<std::size_t>(axis)];
    const std::int32_t steps =
        firmware::steps_from_udeg(static_cast<std::int32_t>(degrees * 1e6), s.steps_per_turn);
    const firmware::Profile profile(static_cast<std::uint32_t>(std::abs(steps)), limits_.at(axis),
                                    firmware::step_timer_hz);
    const auto& edges = edges_[axis];
    EXPECT_EQ(edges.size(), profile.steps()) << "axis " << axis;
    const double first = moment_of(profile, 0.5L);
    double worst = 0;
    for (std::uint32_t k = 0; k < edges.size(); ++k) {
      const double have = static_cast<double>(edges[k] - edges[0]) / static_cast<double>(tick);
      const double want = moment_of(profile, static_cast<long double>(k) + 0.5L) - first;
      worst = std::max(worst, std::abs(have - want));
    }
    return worst;
  }
  /// Ticks after which the curve of constant jerks has gone so many steps, by bisection.
  static double moment_of(const firmware::Profile& profile, long double distance) {
    const auto d = profile.durations();
    const auto t1 = static_cast<long double>(d.jerk), t2 = static_cast<long double>(d.acceleration),
               t3 = static_cast<long double>(d.cruise);
    const long double all = static_cast<long double>(profile.steps());
    const long double jerk = all / (t1 * (t1 + t2) * (2 * t1 + t2 + t3));
    const long double total = 4 * t1 + 2 * t2 + t3;
    const bool late = 2 * distance > all;
    const long double aim = late ? all - distance : distance;
    const auto gone = [&](long double t) {
      const auto cube = [](long double x) { return x > 0 ? x * x * x : 0.0L; };
      return jerk / 6 * (cube(t) - cube(t - t1) - cube(t - t1 - t2) + cube(t - 2 * t1 - t2));
    };
    long double low = 0, high = total / 2 + 1;
    for (int i = 0; i < 70; ++i) {
      const long double middle = (low + high) / 2;
      (gone(middle) < aim ? low : high) = middle;
    }
    return static_cast<double>(late ? total - low : low);
  }

  test::NoisyBench bench_;
  std::map<int, std::vector<mcu::Time>> edges_;
  std::map<int, mcu::Time> ended_;
  mcu::Time shortest_high_ = mcu::never, shortest_low_ = mcu::never;
  mcu::McuBoard board_{bench_,
                       {.image = UMOV_STM32F407_ELF,
                        .on_step =
                            [this](int axis, mcu::Time moment) {
                              edges_[axis].push_back(moment);
                              shortest_low_ = std::min(shortest_low_, moment - ended_[axis]);
                            },
                        .on_step_end =
                            [this](int axis, mcu::Time moment) {
                              ended_[axis] = moment;
                              if (edges_[axis].empty()) return;  // the pin becomes an output
                              shortest_high_ =
                                  std::min(shortest_high_, moment - edges_[axis].back());
                            }}};
  std::unique_ptr<instrument::Session> session_;
  std::map<int, firmware::MotionLimits> limits_;
  std::uint32_t program_ = 100;
  std::uint64_t spent_ = 0;
};

TEST_F(StepEdges, EveryEdgeIsOnItsTickAt200000StepsPerSecond) {
  constexpr int detector = 1;
  set_speed(detector, 200'000, 2'000'000, 40'000'000);
  move({{detector, 60}});
  const double worst = worst_edge_ticks(detector, 60);
  EXPECT_LE(worst, 1.0);
  const auto& edges = edges_[detector];
  EXPECT_EQ(edges[30'001] - edges[30'000], 20 * tick) << "200,000 steps/s";
  std::printf(
      "one axis at up to 200,000 steps/s: worst edge %.2f ticks, %.0f instructions a step\n", worst,
      static_cast<double>(spent_) / 60'000);
}

TEST_F(StepEdges, ThreeAxesAt100000StepsPerSecondGiveAllTheirSteps) {
  for (const int axis : {0, 1, 2}) set_speed(axis, 100'000, 1'000'000, 20'000'000);
  move({{0, 40}, {1, -40}, {2, 41}});
  EXPECT_EQ(edges_[0].size(), 40'000u);
  EXPECT_EQ(edges_[1].size(), 40'000u);
  EXPECT_EQ(edges_[2].size(), 41'000u);
  const double worst =
      std::max({worst_edge_ticks(0, 40), worst_edge_ticks(1, -40), worst_edge_ticks(2, 41)});
  EXPECT_LE(worst, 1.0);
  EXPECT_EQ(bench_.stages.position[0], 40'000);
  EXPECT_EQ(bench_.stages.position[1], -40'000);
  std::printf(
      "three axes at up to 100,000 steps/s: worst edge %.2f ticks, %.0f instructions a step\n",
      worst, static_cast<double>(spent_) / 121'000);
}

/// Six handlers of some 430 instructions in a row take longer than the shortest interval of 14 us:
/// an edge may then be set after its tick. It comes late, but it comes, and the next ones keep to
/// their ticks.
TEST_F(StepEdges, SixAxesAtFullSpeedLoseNoStepAndStayWithinEightMicroseconds) {
  for (int axis = 0; axis < 6; ++axis) {
    const auto& s = firmware::default_axes[static_cast<std::size_t>(axis)];
    set_speed(axis, s.speed_mdeg_s, s.acceleration_mdeg_s2, s.jerk_mdeg_s3);
  }
  const std::map<int, double> targets = {{0, 20}, {1, 20}, {2, 20}, {3, 150}, {4, 150}, {5, 150}};
  move(targets);
  double worst = 0;
  for (const auto& [axis, angle] : targets) worst = std::max(worst, worst_edge_ticks(axis, angle));
  EXPECT_LE(worst, 32.0);
  EXPECT_GE(mcu::seconds(shortest_high_), 2e-6);
  EXPECT_GE(mcu::seconds(shortest_low_), 1e-6) << "late edges, too";
  for (const auto& [axis, angle] : targets) {
    const auto& s = firmware::default_axes[static_cast<std::size_t>(axis)];
    EXPECT_EQ(bench_.stages.position[static_cast<std::size_t>(axis)],
              firmware::steps_from_udeg(static_cast<std::int32_t>(angle * 1e6), s.steps_per_turn));
  }
  std::printf("six axes at full speed (300,000 steps/s): worst edge %.2f ticks\n", worst);
  EXPECT_EQ(board_.chip().watchdog_resets(), 0u);
}

}  // namespace
}  // namespace umov
