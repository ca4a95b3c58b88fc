#include <gtest/gtest.h>

#include <set>

#include "tests/unit/firmware/bench.hpp"

namespace umov::test {
namespace {

/// Runs a program the way a careful host does, over a link that may lose frames, and keeps count.
class ScanHost {
 public:
  ScanHost(Bench& bench, std::uint32_t rows, double loss = 0, unsigned seed = 1)
      : bench_(bench), rows_(rows), loss_(loss), random_(seed) {}

  bool begin(std::uint32_t first = 0) {
    next_ = first;
    return bench_.ask(pr::ProgramBegin{7, first, rows_}).has_value();
  }
  bool complete() const { return next_ == rows_; }
  /// Some milliseconds: takes what has come, feeds rows, acknowledges.
  void turn() {
    bench_.board.run_for(5'000);
    bench_.listen();
    while (!bench_.heard.records.empty()) {
      const pr::Record r = bench_.heard.records.front();
      bench_.heard.records.pop_front();
      if (lost()) continue;
      ++received_;
      if (r.program_id != 7 || r.index < next_) continue;
      early_[r.index] = r;
    }
    while (early_.count(next_) != 0) {
      taken.push_back(early_[next_]);
      early_.erase(next_++);
    }
    while (!bench_.heard.credits.empty()) {
      const pr::RowCredit c = bench_.heard.credits.front();
      bench_.heard.credits.pop_front();
      if (lost()) continue;
      for (std::uint32_t i = c.next_row; i < c.next_row + c.free_slots && i < rows_; ++i) {
        if (!lost()) bench_.send(Bench::row(i));
      }
    }
    if (next_ != acknowledged_ && !lost()) {
      bench_.send(pr::RecordAck{7, next_});
      acknowledged_ = next_;
    } else if (++quiet_ % 40 == 0) {
      bench_.send(pr::RecordAck{7, next_});  // the last one may have been lost
    }
  }
  bool run(int turns = 200'000) {
    while (!complete() && turns-- > 0) turn();
    for (int i = 0; i < 100 && bench_.status().first_unacknowledged != rows_; ++i) {
      bench_.send(pr::RecordAck{7, next_});
    }
    return complete();
  }
  void expect_each_row_once(std::uint32_t first = 0) const {
    ASSERT_EQ(taken.size(), rows_ - first);
    for (std::uint32_t i = 0; i < taken.size(); ++i) {
      ASSERT_EQ(taken[i].index, first + i);
      ASSERT_EQ(taken[i].position_steps[1],
                fw::steps_from_udeg(Bench::row(first + i).target_udeg[1], 360'000));
      if (i > 0) {
        ASSERT_GT(taken[i].time_us, taken[i - 1].time_us);
      }
    }
  }
  std::vector<pr::Record> taken;
  std::uint64_t received() const { return received_; }

 private:
  bool lost() { return std::uniform_real_distribution<>(0, 1)(random_) < loss_; }
  Bench& bench_;
  std::uint32_t rows_;
  double loss_;
  std::mt19937 random_;
  std::uint32_t next_ = 0, acknowledged_ = 0;
  int quiet_ = 0;
  std::uint64_t received_ = 0;
  std::map<std::uint32_t, pr::Record> early_;
};

struct Scan : testing::Test {
  SmallWorld world;
  Bench bench{world};
  void SetUp() override {
    ASSERT_TRUE(bench.hello());
    ASSERT_TRUE(bench.home_all());
  }
  std::uint8_t clear(pr::Fault f) {
    return bench.ask(pr::ClearFault{static_cast<std::uint8_t>(f)}).has_value();
  }
};

TEST_F(Scan, GivesOneRecordARowInOrder) {
  ScanHost host(bench, 300);
  ASSERT_TRUE(host.begin());
  ASSERT_TRUE(host.run());
  host.expect_each_row_once();
  EXPECT_EQ(bench.state(), pr::State::idle);
  EXPECT_EQ(bench.status().program_id, 7u);
  EXPECT_EQ(bench.status().first_unacknowledged, 300u);
  EXPECT_TRUE(world.dark());
}

TEST_F(Scan, MeasuresTheSquareWaveOfTheLaser) {
  ScanHost host(bench, 3);
  ASSERT_TRUE(host.begin());
  ASSERT_TRUE(host.run());
  const pr::Record& r = host.taken[2];
  const double x = 2.0 * static_cast<double>(r.signal_x) / (r.samples * 32767.0);
  EXPECT_NEAR(x, 500 * 4 / std::numbers::pi, 0.3);
  EXPECT_NEAR(static_cast<double>(r.signal_y) / static_cast<double>(r.signal_x), 0, 1e-6);
  EXPECT_EQ(r.samples, 400u);
  EXPECT_EQ(r.saturated, 0u);
  EXPECT_EQ(r.signal_x_se, 0u);
}

TEST_F(Scan, TellsTheDirectionOfTheLastDetectorMove) {
  // Rows 0 … 39 go up, row 40 goes back to 0.
  ScanHost host(bench, 42);
  ASSERT_TRUE(host.begin());
  ASSERT_TRUE(host.run());
  EXPECT_EQ(host.taken[0].direction, 1);  // at start
  EXPECT_EQ(host.taken[39].direction, 1);
  EXPECT_EQ(host.taken[40].direction, -1);
  EXPECT_EQ(host.taken[41].direction, 1);
}

TEST_F(Scan, LosesAndDoublesNothingOverALinkThatDropsAThirdOfAllFrames) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    ScanHost host(bench, 400, 0.33, seed);
    ASSERT_TRUE(host.begin());
    ASSERT_TRUE(host.run());
    host.expect_each_row_once();
    EXPECT_GT(host.received(), 400u);  // some came again
  }
}

TEST_F(Scan, WaitsForTheHostWhenTheRecordRingIsFull) {
  ASSERT_TRUE(bench.ask(pr::ProgramBegin{7, 0, 1000}));
  for (int i = 0; i < 3000; ++i) {
    bench.board.run_for(5'000);
    const pr::Status s = bench.status();
    for (std::uint32_t row = s.next_row; row < s.next_record + fw::row_capacity && row < 1000;
         ++row) {
      bench.send(Bench::row(row));
    }
  }
  EXPECT_EQ(bench.state(), pr::State::waiting_for_host);
  EXPECT_EQ(bench.status().next_record, fw::record_capacity);
  EXPECT_EQ(bench.status().first_unacknowledged, 0u);
  bench.send(pr::RecordAck{7, 100});
  bench.board.run_for(100'000);
  EXPECT_EQ(bench.state(), pr::State::scanning);
  EXPECT_EQ(bench.status().first_unacknowledged, 100u);
}

TEST_F(Scan, WaitsForRowsAndAsksForThem) {
  ASSERT_TRUE(bench.ask(pr::ProgramBegin{7, 0, 10}));
  bench.listen();
  ASSERT_FALSE(bench.heard.credits.empty());
  EXPECT_EQ(bench.heard.credits.front().next_row, 0u);
  EXPECT_EQ(bench.heard.credits.front().free_slots, 10);
  bench.board.run_for(10'000);
  EXPECT_EQ(bench.state(), pr::State::waiting_for_rows);
  bench.heard.credits.clear();
  bench.board.run_for(1'000'000);
  bench.listen();
  EXPECT_NEAR(static_cast<double>(bench.heard.credits.size()), 10, 1);
}

TEST_F(Scan, RowsThatRunOutAreNoFaultButSoonDark) {
  ASSERT_TRUE(bench.ask(pr::ProgramBegin{7, 0, 4}).has_value());
  const auto wait = [&](int ms) {
    for (int i = 0; i < ms / 10; ++i) {
      bench.board.run_for(10'000);
      bench.status();
    }
  };
  bench.send(Bench::row(0));
  wait(500);
  EXPECT_EQ(bench.state(), pr::State::waiting_for_rows);
  EXPECT_FALSE(world.dark()) << "a hitch costs no settling";
  wait(1'000);
  EXPECT_TRUE(world.dark());
  wait(60'000);
  EXPECT_EQ(bench.state(), pr::State::waiting_for_rows);
  EXPECT_EQ(bench.fault(), pr::Fault::none);
  bench.listen();
  EXPECT_TRUE(bench.heard.faults.empty());
  for (std::uint32_t i = 1; i < 4; ++i) bench.send(Bench::row(i));
  wait(1'000);
  bench.listen();
  std::set<std::uint32_t> rows;
  for (const auto& record : bench.heard.records) {
    rows.insert(record.index);
    const double amplitude =
        2.0 * static_cast<double>(record.signal_x) / (record.samples * 32767.0);
    EXPECT_NEAR(amplitude, 500 * 4 / std::numbers::pi, 1) << "with light again";
  }
  EXPECT_EQ(rows.size(), 4u);
}

TEST_F(Scan, IgnoresRowsOutOfOrderAndSaysWhichItWants) {
  ASSERT_TRUE(bench.ask(pr::ProgramBegin{7, 0, 100}));
  bench.send(Bench::row(0));
  bench.send(Bench::row(5));
  bench.send(Bench::row(0));
  bench.listen();
  EXPECT_EQ(bench.heard.credits.back().next_row, 1u);
  EXPECT_EQ(bench.status().next_row, 1u);
}

TEST_F(Scan, RefusesARowBeyondTheLimitsAndStillWantsIt) {
  ASSERT_TRUE(bench.ask(pr::ProgramBegin{7, 0, 2}));
  pr::ProgramRow bad = Bench::row(0);
  bad.target_udeg[0] = 95'000'000;
  const std::uint16_t sequence = bench.send(bad);
  bench.listen();
  ASSERT_EQ(bench.heard.replies.count(sequence), 1u);
  pr::ErrorReply reply;
  ASSERT_TRUE(pr::decode(bench.heard.replies[sequence].second, reply).ok());
  EXPECT_EQ(reply.code, static_cast<std::uint8_t>(pr::Refusal::outside_limits));
  EXPECT_EQ(reply.detail, 0);
  EXPECT_EQ(bench.status().next_row, 0u);
  bad = Bench::row(0);
  bad.gain = 4;
  const std::uint16_t next = bench.send(bad);
  bench.listen();
  ASSERT_TRUE(pr::decode(bench.heard.replies[next].second, reply).ok());
  EXPECT_EQ(reply.code, static_cast<std::uint8_t>(pr::Refusal::out_of_range));
}

TEST_F(Scan, BeginsAtTheRowAskedFor) {
  ScanHost host(bench, 60);
  ASSERT_TRUE(host.begin(25));
  ASSERT_TRUE(host.run());
  host.expect_each_row_once(25);
}

TEST_F(Scan, GoesOnWhenTheSameProgramIsBegunTwiceAndRefusesAnother) {
  ScanHost host(bench, 100);
  ASSERT_TRUE(host.begin());
  for (int i = 0; i < 100; ++i) host.turn();
  const std::uint32_t measured = bench.status().next_record;
  ASSERT_GT(measured, 0u);
  EXPECT_EQ(bench.refusal_of(pr::ProgramBegin{7, 0, 100}), pr::Refusal::none);
  EXPECT_GE(bench.status().next_record, measured);
  EXPECT_EQ(bench.refusal_of(pr::ProgramBegin{8, 0, 100}), pr::Refusal::wrong_state);
  ASSERT_TRUE(host.run());
  host.expect_each_row_once();
}

TEST_F(Scan, PausesAndResumesWithoutLosingOrDoublingARow) {
  ScanHost host(bench, 200);
  ASSERT_TRUE(host.begin());
  for (int n = 0; n < 12; ++n) {
    for (int i = 0; i < 7 + 3 * n; ++i) host.turn();
    ASSERT_TRUE(bench.ask(pr::ProgramControl{0}));
    EXPECT_FALSE(world.shutter);
    for (int i = 0; i < 30; ++i) host.turn();
    const std::uint32_t at = bench.status().next_record;
    for (int i = 0; i < 30; ++i) host.turn();
    EXPECT_EQ(bench.status().next_record, at);
    EXPECT_EQ(bench.state(), pr::State::paused);
    ASSERT_TRUE(bench.ask(pr::ProgramControl{1}));
  }
  ASSERT_TRUE(host.run());
  host.expect_each_row_once();
}

TEST_F(Scan, APausedProgramIsDarkAndWaitsForItsHostWithoutAFault) {
  ASSERT_TRUE(bench.ask(pr::SetLockin{1'000'000, 1, 0, 200, 10}));
  ScanHost host(bench, 60);
  ASSERT_TRUE(host.begin());
  for (int i = 0; i < 2000 && host.taken.size() < 10; ++i) host.turn();
  ASSERT_GE(host.taken.size(), 10u);
  ASSERT_TRUE(world.lasers[0]);
  ASSERT_TRUE(bench.ask(pr::ProgramControl{0}));
  EXPECT_TRUE(world.dark());
  const std::int64_t sum = host.taken.back().signal_x;
  bench.board.run_for(10'000'000);  // of silence
  EXPECT_EQ(bench.fault(), pr::Fault::none);
  EXPECT_EQ(bench.state(), pr::State::paused);
  const std::uint64_t resumed_at_us = bench.board.now_us();
  ASSERT_TRUE(bench.ask(pr::ProgramControl{1}));
  ASSERT_TRUE(host.run());
  host.expect_each_row_once();
  bool first = true;
  for (const pr::Record& r : host.taken) {
    EXPECT_NEAR(static_cast<double>(r.signal_x), static_cast<double>(sum),
                1e-6 * std::abs(static_cast<double>(sum)));
    if (r.time_us < resumed_at_us || !first) continue;
    EXPECT_GE(r.time_us, resumed_at_us + 200'000);  // the light is new: it settles first
    first = false;
  }
  EXPECT_FALSE(first);
}

TEST_F(Scan, KeepsUnacknowledgedRecordsOverAnAbort) {
  ASSERT_TRUE(bench.ask(pr::ProgramBegin{7, 0, 100}));
  for (std::uint32_t i = 0; i < 20; ++i) bench.send(Bench::row(i));
  bench.board.run_for(2'000'000);
  const std::uint32_t measured = bench.status().next_record;
  ASSERT_GT(measured, 5u);
  ASSERT_TRUE(bench.ask(pr::ProgramControl{2}));
  bench.board.run_for(300'000);
  EXPECT_EQ(bench.state(), pr::State::idle);
  EXPECT_TRUE(world.dark());
  bench.listen();
  bench.heard.records.clear();
  bench.send(pr::RecordAck{7, 0});  // asks for all
  bench.listen();
  EXPECT_EQ(bench.heard.records.size(), measured);
}

TEST_F(Scan, SurvivesAHostThatIsAwayForLong) {
  ScanHost host(bench, 500);
  ASSERT_TRUE(host.begin());
  for (int i = 0; i < 200; ++i) host.turn();
  bench.board.run_for(60'000'000);
  EXPECT_TRUE(world.dark());
  ASSERT_TRUE(bench.hello());
  EXPECT_EQ(bench.fault(), pr::Fault::link_lost);
  EXPECT_EQ(bench.state(), pr::State::safe);
  ASSERT_TRUE(clear(pr::Fault::link_lost));
  EXPECT_EQ(bench.state(), pr::State::paused);
  ASSERT_TRUE(bench.ask(pr::ProgramControl{1}));
  ASSERT_TRUE(host.run());
  host.expect_each_row_once();
}

TEST_F(Scan, GoesOnWithANewHostThatSaysHelloInMidScan) {
  ScanHost host(bench, 300);
  ASSERT_TRUE(host.begin());
  for (int n = 0; n < 6; ++n) {
    for (int i = 0; i < 40; ++i) host.turn();
    ASSERT_TRUE(bench.hello());
  }
  ASSERT_TRUE(host.run());
  host.expect_each_row_once();
}

TEST_F(Scan, SendsRecordsAgainEveryTwoSecondsUntilTheyAreAcknowledged) {
  ASSERT_TRUE(bench.ask(pr::ProgramBegin{7, 0, 3}));
  for (std::uint32_t i = 0; i < 3; ++i) bench.send(Bench::row(i));
  bench.board.run_for(600'000);
  bench.listen();
  ASSERT_EQ(bench.status().next_record, 3u);
  bench.heard.records.clear();
  bench.board.run_for(2'500'000);
  bench.listen();
  ASSERT_EQ(bench.heard.records.size(), 3u);
  for (std::uint32_t i = 0; i < 3; ++i) EXPECT_EQ(bench.heard.records[i].index, i % 3);
  bench.send(pr::RecordAck{7, 2});
  bench.heard.records.clear();
  bench.board.run_for(2'500'000);
  bench.listen();
  ASSERT_FALSE(bench.heard.records.empty());
  for (const pr::Record& r : bench.heard.records) EXPECT_EQ(r.index, 2u);
  bench.send(pr::RecordAck{7, 3});
  bench.heard.records.clear();
  bench.board.run_for(2'500'000);
  bench.listen();
  EXPECT_TRUE(bench.heard.records.empty());
}

TEST_F(Scan, PicksTheRangeAndReportsIt) {
  world.signal_codes = 1.2;
  ASSERT_TRUE(bench.ask(pr::ProgramBegin{7, 0, 2}));
  for (std::uint32_t i = 0; i < 2; ++i) {
    pr::ProgramRow r = Bench::row(i);
    r.gain = pr::gain_auto;
    bench.send(r);
  }
  bench.board.run_for(1'000'000);
  bench.listen();
  ASSERT_GE(bench.heard.records.size(), 2u);
  const pr::Record& r = bench.heard.records[1];
  EXPECT_EQ(r.gain, 3);
  EXPECT_EQ(r.saturated, 0u);
  EXPECT_NEAR(2.0 * static_cast<double>(r.signal_x) / (r.samples * 32767.0),
              1200 * 4 / std::numbers::pi, 1);
}

TEST_F(Scan, PutsTheTimeOfARecordAtTheCentreOfItsIntegration) {
  ASSERT_TRUE(bench.ask(pr::SetLockin{1'000'000, 1, 0, 0, 10}));
  ASSERT_TRUE(bench.ask(pr::ProgramBegin{7, 0, 1}));
  pr::ProgramRow r = Bench::row(0);
  r.dwell_ms = 1000;
  bench.send(r);
  const std::uint64_t start = bench.board.now_us();
  bench.board.run_for(1'100'000);
  bench.listen();
  ASSERT_GE(bench.heard.records.size(), 1u);
  // Half a second and the lead-in of one period after the tick that starts the row.
  EXPECT_NEAR(static_cast<double>(bench.heard.records[0].time_us - start), 501'000, 2'000);
}

TEST_F(Scan, IsDeterministic) {
  const auto run = [] {
    SmallWorld w;
    Bench b(w);
    b.hello();
    b.home_all();
    ScanHost host(b, 50);
    host.begin();
    host.run();
    return host.taken;
  };
  const auto first = run(), second = run();
  ASSERT_EQ(first.size(), second.size());
  for (std::size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(first[i].time_us, second[i].time_us);
    EXPECT_EQ(first[i].signal_x, second[i].signal_x);
  }
}

}  // namespace
}  // namespace umov::test
