// An external reference at the pins of the emulated chip: the image that is flashed captures its
// edges, locks and detects against it as the native core does.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/mcu_board/reference_runs.hpp"

namespace umov {
namespace {

using protocol::ReferenceState;
using test::McuRig;
using test::NativeRig;
using test::OutsideReference;

template <class Rig>
class OutsideReferenceTest : public testing::Test {};
using Rigs = testing::Types<NativeRig, McuRig>;
TYPED_TEST_SUITE(OutsideReferenceTest, Rigs);

TYPED_TEST(OutsideReferenceTest, IsLockedWithinTwentyPeriods) {
  for (const double hz : {43.7, 437.0, 1013.7}) {
    const double periods = test::periods_to_lock<TypeParam>({.frequency_hz = hz});
    std::printf("%s, %.1f Hz: %.1f periods\n", TypeParam::name, hz, periods);
    EXPECT_LE(periods, 20) << hz;
  }
}

TYPED_TEST(OutsideReferenceTest, IsHeldWithinTenThousandthOfARadianRms) {
  for (const double hz : {87.3, 1013.7, 9973.0}) {
    const test::Hold hold = test::hold<TypeParam>({.frequency_hz = hz, .wander = 1e-5}, 40);
    std::printf("%s, %.1f Hz: %.2g rad rms about %.2g in %d records\n", TypeParam::name, hz,
                hold.rms_rad, hold.mean_rad, hold.records);
    EXPECT_EQ(hold.records, 40);
    EXPECT_LT(std::hypot(hold.rms_rad, hold.mean_rad), 1e-4) << hz;
  }
}

TYPED_TEST(OutsideReferenceTest, ThatStopsIsTheFaultReferenceLost) {
  TypeParam rig;
  rig.stages().reference = OutsideReference{.frequency_hz = 437};
  instrument::Session session(rig.connect());
  test::home_all(session);
  session.request(test::external_lockin());
  rig.stages().reference->stops_s = rig.now_s() + 0.3;
  test::Records records;
  instrument::ProgramStream stream(
      {.program_id = 9, .row_count = 100},
      [](std::uint32_t index) { return test::still_row(index, 20); }, records);
  try {
    stream.run(session);
    FAIL() << "measured without a reference";
  } catch (const instrument::Faulted& faulted) {
    EXPECT_EQ(faulted.fault(), protocol::Fault::reference_lost);
    EXPECT_NE(std::string(faulted.what()).find("external reference"), std::string::npos);
  }
  EXPECT_TRUE(rig.stages().dark());
  EXPECT_GT(records.all.size(), 5u);
  EXPECT_LT(records.all.size(), 20u);
  const auto status = session.request(protocol::GetStatus{});
  EXPECT_EQ(static_cast<ReferenceState>(status.reference_state), ReferenceState::absent);
}

TEST(OutsideReference, FasterThanItMayBeTakesLittleOfTheProcessor) {
  McuRig rig;
  rig.stages().reference = OutsideReference{.frequency_hz = 90'000};
  instrument::Session session(rig.connect());
  const auto& chip = rig.board.chip();
  const auto before = chip.instructions();
  const double from_s = rig.now_s();
  for (int i = 0; i < 10; ++i) session.poll(std::chrono::milliseconds(10));
  const double share =
      static_cast<double>(chip.instructions() - before) / (rig.now_s() - from_s) / 168e6;
  EXPECT_LT(share, 0.15);
  const auto status = session.request(protocol::GetStatus{});
  EXPECT_EQ(static_cast<ReferenceState>(status.reference_state), ReferenceState::out_of_range);
}

}  // namespace
}  // namespace umov
