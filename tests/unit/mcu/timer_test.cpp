// The timer's compare channels to the tick, its update and trigger.
#include "hil/mcu/timer.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "host/errors/error.hpp"

namespace umov::mcu {
namespace {

constexpr std::uint32_t cr1 = 0x00, cr2 = 0x04, dier = 0x0C, sr = 0x10, egr = 0x14, ccmr1 = 0x18,
                        ccer = 0x20, cnt = 0x24, psc = 0x28, arr = 0x2C, ccr1 = 0x34, ccr2 = 0x38;
constexpr std::uint32_t high_on_match = 1u << 4, force_low = 4u << 4, force_high = 5u << 4;
constexpr Time cycle = 4;

class TimerTest : public testing::Test {
 protected:
  /// 21 cycles a tick, free-running.
  void run_freely() {
    timer.write(cr1, 4);
    timer.write(psc, 20);
    timer.write(egr, 1);
    timer.write(ccer, 0x11);
    timer.write(cr1, 5);
  }
  void advance(Time by) { scheduler.run_until(scheduler.now() + by); }

  Scheduler scheduler;
  std::vector<std::pair<Time, bool>> edges;  // of channel 1
  std::vector<Time> triggers;
  int requests = 0;
  bool interrupt = false;
  Timer timer{"TIM2",
              0xFFFF'FFFF,
              scheduler,
              [] { return cycle; },
              {.interrupt = [this](bool level) { interrupt = level; },
               .dma_request = [this](int) { ++requests; },
               .trigger = [this] { triggers.push_back(scheduler.now()); },
               .on_output =
                   [this](int channel, bool level) {
                     if (channel == 1) edges.emplace_back(scheduler.now(), level);
                   }}};
};

constexpr Time tick = 21 * cycle;

TEST_F(TimerTest, CountsWithItsPrescaler) {
  run_freely();
  advance(1000 * tick + tick / 2);
  EXPECT_EQ(timer.read(cnt), 1000u);
  timer.write(dier, 2);  // an access does not shift the ticks
  advance(tick / 2);
  EXPECT_EQ(timer.read(cnt), 1001u);
}

TEST_F(TimerTest, RaisesTheOutputOnTheVeryTickAndAsksForAnInterrupt) {
  run_freely();
  timer.write(dier, 2);
  timer.write(ccmr1, high_on_match);
  timer.write(ccr1, 777);
  advance(5000 * tick);
  ASSERT_EQ(edges.size(), 1u);
  EXPECT_EQ(edges[0], std::pair(777 * tick, true));
  EXPECT_TRUE(interrupt);
  timer.write(sr, ~2u);
  EXPECT_FALSE(interrupt);
  timer.write(ccmr1, force_low);
  EXPECT_FALSE(edges.back().second);
}

TEST_F(TimerTest, AMatchThatHasGoneByDoesNotComeUntilTheCountComesRound) {
  run_freely();
  advance(100 * tick);
  timer.write(ccmr1, high_on_match);
  timer.write(ccr1, 99);
  advance(10'000 * tick);
  EXPECT_TRUE(edges.empty());
  timer.write(cnt, 0xFFFF'FFFF);
  advance(101 * tick);
  EXPECT_EQ(edges.size(), 1u);
}

TEST_F(TimerTest, ASoftwareEventSetsTheFlagAndLeavesTheOutput) {
  run_freely();
  timer.write(dier, 2);
  timer.write(ccmr1, high_on_match);
  timer.write(ccr1, 0xFFFF'0000);
  timer.write(egr, 2);
  EXPECT_TRUE(interrupt);
  EXPECT_TRUE(edges.empty());
  timer.write(ccmr1, force_high);
  EXPECT_EQ(edges.size(), 1u);
}

TEST_F(TimerTest, FrozenKeepsTheOutputWhereItIs) {
  run_freely();
  timer.write(ccmr1, high_on_match);
  timer.write(ccr1, 50);
  advance(20 * tick);
  timer.write(ccmr1, 0);
  advance(100 * tick);
  EXPECT_TRUE(edges.empty());
  EXPECT_NE(timer.read(sr) & 2u, 0u) << "the comparison goes on";
}

TEST_F(TimerTest, UpdatesAtItsPeriodAndAsksForDmaAtAMatch) {
  timer.write(arr, 1679);
  timer.write(ccr1, 840);
  timer.write(ccr2, 0xFFFF'FFFF);
  timer.write(cr2, 2u << 4);
  timer.write(dier, 1u << 9);
  timer.write(cnt, 839);
  timer.write(cr1, 5);
  advance(cycle);
  EXPECT_EQ(requests, 1);
  advance(10 * 1680 * cycle);
  ASSERT_EQ(triggers.size(), 10u);
  EXPECT_EQ(triggers[0], 841 * cycle);
  EXPECT_EQ(triggers[9] - triggers[0], 9 * 1680 * cycle);
  EXPECT_EQ(requests, 11);
  timer.write(cr1, 4);
  advance(10 * 1680 * cycle);
  EXPECT_EQ(triggers.size(), 10u);
}

TEST_F(TimerTest, ModesThatAreNotModelledAreRefused) {
  EXPECT_THROW(timer.write(ccmr1, 6u << 4), Error);  // PWM
  EXPECT_THROW(timer.write(ccmr1, 3), Error);        // capture of the trigger
  EXPECT_THROW(timer.write(cr1, 0x11), Error);       // down
  EXPECT_THROW(timer.read(0x54), Error);
}

TEST_F(TimerTest, CapturesItsCountAtARisingInputAndTellsOfOneThatWasLost) {
  timer.write(ccmr1, 1);
  timer.write(dier, 2);
  run_freely();
  advance(1000 * tick + tick / 2);
  timer.rise(1);
  EXPECT_TRUE(interrupt);
  advance(10 * tick);
  EXPECT_EQ(timer.read(sr) & 0x202u, 2u);
  EXPECT_EQ(timer.read(ccr1), 1000u);
  EXPECT_FALSE(interrupt) << "reading what was captured ends it";
  timer.rise(1);
  advance(tick);
  timer.rise(1);
  EXPECT_EQ(timer.read(sr) & 0x202u, 0x202u);
  EXPECT_EQ(timer.read(ccr1), 1011u) << "the later one";
  timer.write(sr, 0);
  timer.write(ccer, 0);
  timer.rise(1);
  EXPECT_EQ(timer.read(sr) & 2u, 0u) << "not enabled";
  EXPECT_THROW(timer.write(ccmr1, 0xF1), Error) << "a filter is not modelled";
  EXPECT_THROW(timer.write(ccmr1, 2), Error) << "nor the other input";
}

}  // namespace
}  // namespace umov::mcu
