// Records against an external reference on the native board: only when locked, and never of a
// reference that was away.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/unit/firmware/bench.hpp"

namespace umov::test {
namespace {

using pr::ReferenceState;

constexpr pr::SetLockin external{.reference_mhz = 1'000'000,
                                 .harmonic = 1,
                                 .phase_udeg = 0,
                                 .settle_ms = 0,
                                 .blocks = 10,
                                 .source = 1};

struct Chopped {
  explicit Chopped(const OutsideReference& chopper) {
    world.chopper = chopper;
    EXPECT_TRUE(bench.hello());
    EXPECT_TRUE(bench.home_all());
    EXPECT_TRUE(bench.ask(external).has_value());
  }
  ReferenceState reference() { return static_cast<ReferenceState>(bench.status().reference_state); }
  /// Feeds rows and takes records until there are `count`, or a fault, or nothing comes.
  void run(std::uint32_t count, std::uint16_t dwell_ms) {
    for (int turn = 0; turn < 20'000 && records.size() < count; ++turn) {
      bench.board.run_for(5'000);
      const auto status = bench.status();
      for (const auto& record : bench.heard.records) {
        if (record.index != records.size()) continue;
        records.push_back(record);
      }
      bench.heard.records.clear();
      bench.send(pr::RecordAck{7, static_cast<std::uint32_t>(records.size())});
      if (status.fault != 0) return;
      for (std::uint32_t i = status.next_row; i < std::min(count, status.next_row + 4); ++i) {
        pr::ProgramRow row = Bench::row(i);
        row.target_udeg = {};
        row.dwell_ms = dwell_ms;
        bench.send(row);
      }
    }
  }

  SmallWorld world;
  Bench bench{world};
  std::vector<pr::Record> records;
};

double phase_of(const pr::Record& record) {
  return std::atan2(static_cast<double>(record.signal_y), static_cast<double>(record.signal_x));
}

double amplitude_of(const pr::Record& record) {
  return 2.0 / (record.samples * 32767.0) *
         std::hypot(static_cast<double>(record.signal_x), static_cast<double>(record.signal_y));
}

/// When the last sample of a record was taken.
double end_s(const pr::Record& record) {
  return 1e-6 * static_cast<double>(record.time_us) +
         0.5 * static_cast<double>(record.samples) / fw::sample_rate_hz;
}

TEST(OutsideReference, IsLockedWithinTwentyPeriodsOfItsFirstEdge) {
  SmallWorld world;
  Bench bench(world);
  world.chopper = OutsideReference{.frequency_hz = 50};
  ASSERT_TRUE(bench.hello());
  int ms = 0;
  while (bench.status().reference_state != 3 && ms < 2000) {
    bench.board.run_for(1'000);
    ++ms;
  }
  EXPECT_LE(ms, 20 * 21) << "the first edge comes after a period";
  EXPECT_NEAR(bench.status().reference_mhz, 50'000, 1);
}

TEST(OutsideReference, IsHeldWithinTenThousandthOfARadianInEveryRecord) {
  struct Case {
    double hz;
    std::uint16_t dwell_ms;
  };
  for (const Case c : {Case{87.3, 120}, Case{437, 25}, Case{1013.7, 20}, Case{9973, 10}}) {
    Chopped chopped({.frequency_hz = c.hz, .wander = 1e-5});
    ASSERT_TRUE(chopped.bench.ask(pr::ProgramBegin{7, 0, 300}).has_value());
    chopped.run(300, c.dwell_ms);
    ASSERT_EQ(chopped.records.size(), 300u) << c.hz;
    double squares = 0;
    for (const auto& record : chopped.records) {
      squares += phase_of(record) * phase_of(record);
      EXPECT_NEAR(amplitude_of(record), 1500, 0.15);
      EXPECT_NEAR(record.samples, 100 * c.dwell_ms, std::max(1e5 / c.hz, 10.0 * c.dwell_ms));
    }
    const double rms = std::sqrt(squares / static_cast<double>(chopped.records.size()));
    std::printf("%8.1f Hz: %.2g rad rms over 300 records of %d ms\n", c.hz, rms, c.dwell_ms);
    EXPECT_LT(rms, 1e-4) << c.hz;
  }
}

TEST(OutsideReference, PhaseSettingTurnsXAndY) {
  Chopped chopped({.frequency_hz = 437});
  pr::SetLockin turned = external;
  turned.phase_udeg = 30'000'000;
  ASSERT_TRUE(chopped.bench.ask(turned).has_value());
  ASSERT_TRUE(chopped.bench.ask(pr::ProgramBegin{7, 0, 1}).has_value());
  chopped.run(1, 100);
  ASSERT_EQ(chopped.records.size(), 1u);
  EXPECT_NEAR(phase_of(chopped.records[0]), -30 * std::numbers::pi / 180, 1e-4);
}

TEST(OutsideReference, WithoutOneAProgramIsRefusedByName) {
  Chopped chopped({.frequency_hz = 437, .stops_s = 0});
  EXPECT_EQ(chopped.reference(), ReferenceState::absent);
  EXPECT_EQ(chopped.bench.refusal_of(pr::ProgramBegin{7, 0, 1}), pr::Refusal::no_reference);
  EXPECT_EQ(chopped.bench.refusal.detail, static_cast<int>(ReferenceState::absent));
  pr::SetLockin internal = external;
  internal.source = 0;
  ASSERT_TRUE(chopped.bench.ask(internal).has_value());
  EXPECT_TRUE(chopped.bench.ask(pr::ProgramBegin{7, 0, 1}).has_value());
}

TEST(OutsideReference, BeyondTheRangeOrTheHarmonicIsRefusedByName) {
  Chopped slow({.frequency_hz = 6});
  EXPECT_EQ(slow.bench.refusal_of(pr::ProgramBegin{7, 0, 1}), pr::Refusal::no_reference);
  EXPECT_EQ(slow.bench.refusal.detail, static_cast<int>(ReferenceState::out_of_range));
  Chopped fast({.frequency_hz = 9000});
  pr::SetLockin harmonic = external;
  harmonic.harmonic = 6;
  ASSERT_TRUE(fast.bench.ask(harmonic).has_value());
  EXPECT_EQ(fast.bench.refusal_of(pr::ProgramBegin{7, 0, 1}), pr::Refusal::no_reference);
  EXPECT_EQ(fast.bench.refusal.detail, static_cast<int>(ReferenceState::out_of_range));
}

TEST(OutsideReference, ThatStopsIsOneNamedFaultAndTheRowIsMeasuredWhenItIsBack) {
  Chopped chopped({.frequency_hz = 437});
  const double now_s = static_cast<double>(chopped.bench.board.now_us()) * 1e-6;
  chopped.world.chopper->stops_s = now_s + 1.0;
  ASSERT_TRUE(chopped.bench.ask(pr::ProgramBegin{7, 0, 30}).has_value());
  chopped.run(30, 100);
  EXPECT_EQ(chopped.bench.fault(), pr::Fault::reference_lost);
  EXPECT_TRUE(chopped.world.dark());
  const auto before = chopped.records.size();
  EXPECT_GE(before, 5u);
  EXPECT_LT(before, 12u);
  for (const auto& record : chopped.records) EXPECT_LT(std::abs(phase_of(record)), 3e-4);
  chopped.bench.board.run_for(1'000'000);
  chopped.bench.listen();
  ASSERT_EQ(chopped.bench.heard.faults.size(), 1u);
  EXPECT_EQ(chopped.bench.heard.faults[0].fault,
            static_cast<std::uint8_t>(pr::Fault::reference_lost));

  const auto lost = static_cast<std::uint8_t>(pr::Fault::reference_lost);
  ASSERT_TRUE(chopped.bench.ask(pr::ClearFault{lost}).has_value());
  EXPECT_EQ(chopped.bench.refusal_of(pr::ProgramControl{1}), pr::Refusal::no_reference);
  chopped.world.chopper->stops_s = std::numeric_limits<double>::infinity();
  chopped.bench.board.run_for(5'000);
  chopped.bench.board.run_for(100'000);
  ASSERT_TRUE(chopped.bench.ask(pr::ProgramControl{1}).has_value());
  chopped.run(30, 100);
  ASSERT_EQ(chopped.records.size(), 30u);
  for (const auto& record : chopped.records) EXPECT_LT(std::abs(phase_of(record)), 3e-4);
}

/// Wherever in a record it stops, also shortly before its end: none of light that stood still.
TEST(OutsideReference, ThatStopsLeavesNoRecordOfLightThatStoodStill) {
  Chopped chopped({.frequency_hz = 437});
  const auto lost = static_cast<std::uint8_t>(pr::Fault::reference_lost);
  std::size_t kept = 0;
  for (int i = 0; i < 40; ++i) {
    const double now_s = static_cast<double>(chopped.bench.board.now_us()) * 1e-6;
    const double stops_s = now_s + 0.1 + 1.1e-3 * i;
    chopped.world.chopper->stops_s = stops_s;
    ASSERT_TRUE(chopped.bench.ask(pr::ProgramBegin{7, 0, 30}).has_value());
    chopped.records.clear();
    chopped.run(30, 20);
    ASSERT_EQ(chopped.bench.fault(), pr::Fault::reference_lost) << i;
    kept += chopped.records.size();
    for (const auto& record : chopped.records) {
      EXPECT_NEAR(amplitude_of(record), 1500, 0.15) << i;
      EXPECT_LT(std::abs(phase_of(record)), 3e-4) << i;
      EXPECT_LT(end_s(record), stops_s) << i;
    }
    ASSERT_TRUE(chopped.bench.ask(pr::ProgramControl{2}).has_value());
    ASSERT_TRUE(chopped.bench.ask(pr::ClearFault{lost}).has_value());
    chopped.world.chopper->stops_s = std::numeric_limits<double>::infinity();
    chopped.bench.board.run_for(100'000);
  }
  EXPECT_GT(kept, 80u) << "what was complete before is kept";
}

TEST(OutsideReference, IsNoMatterOfInternalDetection) {
  Chopped chopped({.frequency_hz = 437, .stops_s = 0});
  pr::SetLockin internal = external;
  internal.source = 0;
  ASSERT_TRUE(chopped.bench.ask(internal).has_value());
  ASSERT_TRUE(chopped.bench.ask(pr::ProgramBegin{7, 0, 3}).has_value());
  chopped.run(3, 10);
  EXPECT_EQ(chopped.records.size(), 3u);
  EXPECT_EQ(chopped.world.step_per_sample, 42'949'673u);
}

}  // namespace
}  // namespace umov::test
