// Which exception is taken when: priorities, masks, levels.
#include "hil/mcu/nvic.hpp"

#include <gtest/gtest.h>

#include "host/errors/error.hpp"

namespace umov::mcu {
namespace {

constexpr std::uint32_t set_enable = 0x100, priorities = 0x400, aircr = 0xD0C;

class NvicTest : public testing::Test {
 protected:
  void enable(int irq, std::uint32_t priority) {
    nvic.write(set_enable + 4 * (static_cast<std::uint32_t>(irq) / 32), 4, 1u << irq % 32);
    nvic.write(priorities + static_cast<std::uint32_t>(irq), 1, priority << 4);
  }
  int take() { return nvic.to_take({}); }
  Nvic nvic;
};

TEST_F(NvicTest, TakesTheMostUrgentAndOfEqualOnesTheLowestNumber) {
  enable(3, 5);
  enable(9, 2);
  enable(40, 2);
  for (const int irq : {3, 40, 9}) nvic.set_line(irq, true);
  EXPECT_EQ(take(), 16 + 9);
  nvic.enter(take());
  EXPECT_EQ(take(), 0) << "an equal one does not preempt";
  nvic.set_line(9, false);
  nvic.leave(16 + 9);
  EXPECT_EQ(take(), 16 + 40);
}

TEST_F(NvicTest, WhatIsNotEnabledWaits) {
  nvic.set_line(7, true);
  EXPECT_EQ(take(), 0);
  enable(7, 0);
  EXPECT_EQ(take(), 16 + 7) << "pending since before it was enabled";
}

TEST_F(NvicTest, PreemptsOnlyTheLessUrgent) {
  enable(1, 4);
  enable(2, 3);
  nvic.set_line(1, true);
  nvic.enter(take());
  nvic.set_line(2, true);
  EXPECT_EQ(take(), 16 + 2);
  nvic.enter(16 + 2);
  EXPECT_EQ(nvic.nesting(), 2u);
  nvic.set_line(2, false);
  nvic.leave(16 + 2);
  EXPECT_EQ(nvic.active(), 16 + 1);
}

TEST_F(NvicTest, ALineStillHighIsTakenAgainALoweredOneIsNot) {
  enable(5, 1);
  nvic.set_line(5, true);
  nvic.enter(take());
  EXPECT_EQ(take(), 0);
  nvic.leave(16 + 5);
  EXPECT_EQ(take(), 16 + 5);
  nvic.enter(take());
  nvic.set_line(5, false);
  nvic.leave(16 + 5);
  EXPECT_EQ(take(), 0);
}

TEST_F(NvicTest, APulseDuringTheHandlerIsNotLost) {
  enable(5, 1);
  nvic.set_line(5, true);
  nvic.enter(take());
  nvic.set_line(5, false);
  nvic.set_line(5, true);
  nvic.set_line(5, false);
  nvic.leave(16 + 5);
  EXPECT_EQ(take(), 16 + 5);
}

TEST_F(NvicTest, MasksHoldOffAndASleeperWakesAllTheSame) {
  enable(4, 6);
  nvic.set_line(4, true);
  EXPECT_EQ(nvic.to_take({.primask = true}), 0);
  EXPECT_TRUE(nvic.wakes({.primask = true}));
  EXPECT_EQ(nvic.to_take({.basepri = 0x60}), 0);
  EXPECT_FALSE(nvic.wakes({.basepri = 0x60}));
  EXPECT_EQ(nvic.to_take({.basepri = 0x70}), 16 + 4);
}

TEST_F(NvicTest, ReturningFromAnExceptionThatIsNotActiveIsRefused) {
  EXPECT_THROW(nvic.leave(16 + 4), Error);
}

TEST_F(NvicTest, OnlyAWriteWithTheKeyResets) {
  nvic.write(aircr, 4, 0x0000'0004);
  EXPECT_FALSE(nvic.reset_requested());
  nvic.write(aircr, 4, 0x05FA'0004);
  EXPECT_TRUE(nvic.reset_requested());
}

TEST_F(NvicTest, RegistersThatAreNotModelledAreNamed) {
  try {
    nvic.read(0xD2C, 4);
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("0x00000D2C"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace umov::mcu
