// A hand controller at the instrument: when its steps are taken, and when not.
#include <gtest/gtest.h>

#include "tests/unit/firmware/bench.hpp"

namespace umov::test {
namespace {

constexpr int detector = 1;

class Hand : public ::testing::Test {
 protected:
  Hand() {
    EXPECT_TRUE(bench.hello());
    EXPECT_TRUE(bench.home_all());
  }
  std::int32_t position() { return bench.board.hand_view(detector).position_udeg; }
  void wait(double seconds) { bench.board.run_for(static_cast<std::uint64_t>(1e6 * seconds)); }

  SmallWorld world;
  Bench bench{world};
};

TEST_F(Hand, steps_add_up_while_the_axis_moves) {
  for (int i = 0; i < 5; ++i) bench.board.jog(detector, 1'000'000);
  wait(2);
  EXPECT_NEAR(position(), 5'000'000, 300);
  for (int i = 0; i < 3; ++i) bench.board.jog(detector, -1'000'000);
  wait(2);
  EXPECT_NEAR(position(), 2'000'000, 300);
}

TEST_F(Hand, a_turn_of_the_knob_needs_no_host) {
  wait(10);  // the host of the homing has long been silent
  bench.board.jog(detector, 40'000'000);
  wait(0.2);
  EXPECT_EQ(bench.board.hand_view(detector).state, pr::State::moving);
  wait(5);
  EXPECT_EQ(bench.board.hand_view(detector).fault, pr::Fault::none);
  EXPECT_NEAR(position(), 40'000'000, 300);
}

TEST_F(Hand, steps_beyond_the_soft_limits_are_not_taken) {
  bench.board.jog(detector, 89'000'000);
  bench.board.jog(detector, 2'000'000);
  wait(10);
  EXPECT_NEAR(position(), 89'000'000, 300);
  EXPECT_EQ(bench.board.hand_view(detector).fault, pr::Fault::none);
}

TEST_F(Hand, its_stop_ends_the_move_and_forgets_what_was_to_come) {
  bench.board.jog(detector, 40'000'000);
  bench.board.jog(detector, 10'000'000);
  wait(0.3);
  bench.board.stop_by_hand(false);
  wait(2);
  const auto stopped = position();
  EXPECT_GT(stopped, 0);
  EXPECT_LT(stopped, 39'000'000);
  wait(2);
  EXPECT_EQ(position(), stopped);
  // So does the host's.
  bench.board.jog(detector, 10'000'000);
  wait(0.1);
  ASSERT_TRUE(bench.ask(pr::Stop{}));
  wait(2);
  const auto again = position();
  EXPECT_LT(again, stopped + 10'000'000 - 1000);
  wait(2);
  EXPECT_EQ(position(), again);
}

TEST_F(Hand, nothing_moves_after_its_emergency_stop_until_that_is_cleared) {
  bench.board.stop_by_hand(true);
  bench.board.jog(detector, 1'000'000);
  wait(1);
  EXPECT_EQ(position(), 0);
  EXPECT_EQ(bench.fault(), pr::Fault::emergency_stop);
  ASSERT_TRUE(bench.ask(pr::ClearFault{static_cast<std::uint8_t>(pr::Fault::emergency_stop)}));
  bench.board.jog(detector, 1'000'000);
  wait(1);
  EXPECT_NEAR(position(), 1'000'000, 300);
}

TEST_F(Hand, a_program_that_runs_is_not_disturbed) {
  ASSERT_TRUE(bench.ask(pr::ProgramBegin{.program_id = 7, .first_row = 0, .row_count = 2}));
  for (std::uint32_t i = 0; i < 2; ++i) bench.send(Bench::row(i));
  bench.board.jog(detector, 20'000'000);
  wait(1);
  bench.listen();
  ASSERT_EQ(bench.heard.records.size(), 2u);
  EXPECT_LT(std::abs(position()), 1'000'000);
}

TEST(HandUnhomed, an_axis_whose_zero_is_not_known_stays_where_it_is) {
  SmallWorld world;
  Bench bench(world);
  bench.board.jog(detector, 1'000'000);
  bench.board.run_for(1'000'000);
  EXPECT_EQ(bench.board.hand_view(detector).position_udeg, 0);
  bench.board.jog(6, 1'000'000);   // no such axis
  bench.board.jog(-1, 1'000'000);  // nor this
}

}  // namespace
}  // namespace umov::test
