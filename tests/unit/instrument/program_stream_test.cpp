#include "host/instrument/program_stream.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <optional>
#include <vector>

#include "host/errors/error.hpp"
#include "host/instrument/link_lost.hpp"
#include "host/instrument/refusals.hpp"
#include "tests/unit/instrument/simulated_link.hpp"

namespace umov::instrument {
namespace {

using namespace std::chrono_literals;
using testing::Cable;
using ::testing::HasSubstr;
using testing::plug_into;

constexpr std::uint32_t our_program = 0xfeed;

ProgramOptions options_for(std::uint32_t rows, std::uint32_t first_missing = 0) {
  ProgramOptions options;
  options.program_id = our_program;
  options.row_count = rows;
  options.first_missing = first_missing;
  return options;
}

protocol::ProgramRow row_of(std::uint32_t index) {
  protocol::ProgramRow row;
  for (std::size_t axis = 0; axis < row.target_udeg.size(); ++axis) {
    row.target_udeg[axis] = static_cast<std::int32_t>(index * 7 + axis);
  }
  row.laser = static_cast<std::uint8_t>(index % 4);
  row.dwell_ms = 1;
  return row;
}

/// Checks order, uniqueness and contents of every record, and knows what is safe.
class CheckingSink final : public RecordSink {
 public:
  explicit CheckingSink(std::uint32_t first = 0) : next_(first), safe_(first) {}

  void take(const protocol::Record& record) override {
    EXPECT_EQ(record.program_id, our_program);
    EXPECT_EQ(record.index, next_) << "records come in order, each once";
    const protocol::ProgramRow row = row_of(record.index);
    EXPECT_EQ(record.position_steps, row.target_udeg);
    EXPECT_EQ(record.laser, row.laser);
    EXPECT_EQ(record.signal_x, std::int64_t{record.index} * 1'000'003);
    next_ = record.index + 1;
  }
  void secure() override {
    safe_ = next_;
    ++secured_;
  }

  std::uint32_t next() const { return next_; }
  std::uint32_t safe() const { return safe_; }
  int secured() const { return secured_; }

 private:
  std::uint32_t next_;
  std::uint32_t safe_;
  int secured_ = 0;
};

/// Fails when the device is told that a record is safe which is not.
void watch_acknowledgements(Cable& cable, const CheckingSink& sink) {
  cable.device.on_ack = [&sink](std::uint32_t next_index) { EXPECT_LE(next_index, sink.safe()); };
}

TEST(ProgramStream, OverACleanLinkEveryRowAndRecordTravelsOnce) {
  Cable cable;
  CheckingSink sink;
  watch_acknowledgements(cable, sink);
  ProgramStream stream(options_for(500), row_of, sink);
  Session session(plug_into(cable));
  EXPECT_TRUE(stream.run(session));
  EXPECT_EQ(sink.safe(), 500u);
  EXPECT_EQ(cable.device.status.first_unacknowledged, 500u) << "the device knows";
  EXPECT_EQ(stream.counters().rows_sent, 500u);
  EXPECT_EQ(stream.counters().rows_sent_again, 0u);
  EXPECT_EQ(stream.counters().programs_begun, 1u);
}

TEST(ProgramStream, TwentyThousandRecordsArriveOnceInOrderOverATerribleLink) {
  Cable cable;
  cable.random.seed(20240607);
  cable.faults = {
      .byte_error = 1e-3, .drop = 0.02, .duplicate = 0.02, .reorder = 0.02, .disconnect = 2e-4};
  constexpr std::uint32_t rows = 20000;
  CheckingSink sink;
  watch_acknowledgements(cable, sink);
  ProgramStream stream(options_for(rows), row_of, sink);
  const auto start = std::chrono::steady_clock::now();
  std::uint64_t sessions = 0;
  while (!stream.complete()) {
    ++sessions;
    ASSERT_LT(sessions, 1000u);
    try {
      Session session(plug_into(cable));
      stream.run(session);
    } catch (const LinkLost&) {
    }
  }
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  EXPECT_EQ(sink.next(), rows);
  EXPECT_EQ(sink.safe(), rows);
  EXPECT_GT(sessions, 5u) << "the link is meant to drop";
  const auto& c = cable.counters;
  RecordProperty("frames", static_cast<int>(c.frames));
  std::printf(
      "[          ] %u records, %llu frames in %.2f s (%.0f s of device time): %llu bytes damaged, "
      "%llu frames "
      "dropped, %llu doubled, %llu swapped, %llu disconnects; %llu rows sent again, %llu duplicate "
      "records, "
      "program begun %llu times, joined %llu times\n",
      rows, static_cast<unsigned long long>(c.frames), seconds,
      static_cast<double>(cable.device.now_us()) * 1e-6,
      static_cast<unsigned long long>(c.damaged_bytes), static_cast<unsigned long long>(c.dropped),
      static_cast<unsigned long long>(c.duplicated), static_cast<unsigned long long>(c.reordered),
      static_cast<unsigned long long>(c.disconnects),
      static_cast<unsigned long long>(stream.counters().rows_sent_again),
      static_cast<unsigned long long>(stream.counters().duplicate_records),
      static_cast<unsigned long long>(stream.counters().programs_begun),
      static_cast<unsigned long long>(stream.counters().programs_joined));
}

TEST(ProgramStream, ShortProgramsOverATerribleLinkEndForEverySeed) {
  // Begin, end, pause and abort are a small part of a long scan; here they are most of it.
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    Cable cable;
    cable.random.seed(seed);
    cable.faults = {
        .byte_error = 1e-3, .drop = 0.1, .duplicate = 0.1, .reorder = 0.1, .disconnect = 0.01};
    const auto rows = static_cast<std::uint32_t>(1 + seed % 25);
    CheckingSink sink;
    watch_acknowledgements(cable, sink);
    ProgramStream stream(options_for(rows), row_of, sink);
    int sessions = 0;
    while (!stream.complete()) {
      ASSERT_LT(++sessions, 200) << "seed " << seed;
      try {
        Session session(plug_into(cable));
        stream.run(session);
      } catch (const LinkLost&) {
      } catch (const Unanswered&) {
      }
    }
    ASSERT_EQ(sink.safe(), rows) << "seed " << seed;
  }
}

TEST(ProgramStream, ALongScanIsNotSlowedDownWhenSequenceNumbersWrap) {
  Cable cable;
  CheckingSink sink;
  constexpr std::uint32_t rows = 80000;  // the numbers, sixteen bits, wrap
  ProgramStream stream(options_for(rows), row_of, sink);
  Session session(plug_into(cable));
  EXPECT_TRUE(stream.run(session));
  EXPECT_EQ(sink.safe(), rows);
  EXPECT_EQ(stream.counters().rows_sent, rows);
  EXPECT_EQ(stream.counters().duplicate_records, 0u);
  const double measuring_us = static_cast<double>(rows * cable.device.measure_us);
  EXPECT_LT(static_cast<double>(cable.device.now_us()), 1.25 * measuring_us);
}

/// Runs until `records` have been taken, then unplugs.
void run_until(ProgramStream& stream, Cable& cable, std::uint32_t records) {
  Session session(plug_into(cable));
  stream.attach(session);
  while (stream.next_index() < records) stream.advance(1ms);
}

TEST(ProgramStream, AfterADroppedLinkItJoinsTheRunningProgram) {
  Cable cable;
  CheckingSink sink;
  ProgramStream stream(options_for(100), row_of, sink);
  run_until(stream, cable, 40);
  cable.device.step(2'000'000);  // the device goes on until it has no rows or no room
  EXPECT_GT(cable.device.status.next_record, stream.next_index());
  EXPECT_LT(cable.device.status.next_record, 100u);
  Session session(plug_into(cable));
  EXPECT_TRUE(stream.run(session));
  EXPECT_EQ(sink.safe(), 100u);
  EXPECT_EQ(stream.counters().programs_begun, 1u);
  EXPECT_EQ(stream.counters().programs_joined, 1u);
}

TEST(ProgramStream, AKilledHostComesBackWithWhatItHasOnDisk) {
  Cable cable;
  std::uint32_t safe = 0;
  {
    CheckingSink sink;
    ProgramStream stream(options_for(100), row_of, sink);
    run_until(stream, cable, 50);
    safe = sink.safe();
    EXPECT_LT(safe, 50u) << "the test wants records that were taken but not safe";
  }
  CheckingSink sink(safe);
  ProgramStream stream(options_for(100, safe), row_of, sink);
  Session session(plug_into(cable));
  EXPECT_TRUE(stream.run(session));
  EXPECT_EQ(sink.safe(), 100u);
  EXPECT_EQ(stream.counters().programs_joined, 1u) << "the device still had the records";
}

TEST(ProgramStream, RecordsThatNeitherEndHasAnyMoreAreMeasuredAgain) {
  Cable cable;
  {
    CheckingSink sink;
    ProgramStream stream(options_for(100), row_of, sink);
    run_until(stream, cable, 60);
  }
  CheckingSink sink(10);  // most of the file was lost after it had been acknowledged
  ProgramStream stream(options_for(100, 10), row_of, sink);
  Session session(plug_into(cable));
  EXPECT_TRUE(stream.run(session));
  EXPECT_EQ(sink.safe(), 100u);
  EXPECT_EQ(stream.counters().programs_begun, 1u);
}

TEST(ProgramStream, AnotherProgramIsEndedAndItsRecordsAreNotMixedIn) {
  Cable cable;
  {
    class AnySink final : public RecordSink {
      void take(const protocol::Record&) override {}
      void secure() override {}
    } any;
    ProgramOptions other = options_for(80);
    other.program_id = 99;
    ProgramStream stream(other, row_of, any);
    run_until(stream, cable, 20);
  }
  CheckingSink sink;
  ProgramStream stream(options_for(30), row_of, sink);
  // A record of the other program that is still in the pipe after the handshake.
  Session session(plug_into(cable));
  testing::Bytes late(protocol::max_wire_frame_size);
  protocol::Record stale;
  stale.program_id = 99;
  late.resize(protocol::FrameWriter::write(std::uint16_t{0}, stale, late));
  stream.attach(session);
  cable.device.sent.push_back(late);
  while (!stream.advance(10ms)) {
  }
  EXPECT_EQ(sink.safe(), 30u);
  EXPECT_GE(stream.counters().stale_records, 1u);
}

TEST(ProgramStream, APowerCutOfTheDeviceCostsNoRecord) {
  Cable cable;
  CheckingSink sink;
  ProgramStream stream(options_for(100), row_of, sink);
  {
    Session session(plug_into(cable));
    stream.attach(session);
    while (stream.next_index() < 33) stream.advance(1ms);
    cable.device.restart();
    EXPECT_THROW(
        {
          while (!stream.advance(1s)) {
          }
        },
        LinkLost);
    EXPECT_EQ(sink.safe(), sink.next()) << "what was taken is secured before the error is thrown";
  }
  Session session(plug_into(cable));
  EXPECT_TRUE(stream.run(session));
  EXPECT_EQ(sink.safe(), 100u);
  EXPECT_EQ(stream.counters().programs_begun, 2u);
}

TEST(ProgramStream, AFaultIsNamedWithItsRowAndRemedyAfterTheRecordsBeforeIt) {
  for (const bool announced : {true, false}) {  // fault_event may get lost: the heartbeat tells
    Cable cable;
    CheckingSink sink;
    ProgramStream stream(options_for(100), row_of, sink);
    Session session(plug_into(cable));
    stream.attach(session);
    while (stream.next_index() < 21) stream.advance(1ms);
    cable.device.latch(protocol::Fault::interlock, announced);
    const std::uint32_t row = cable.device.status.next_record;
    try {
      while (!stream.advance(1s)) {
      }
      FAIL() << "no error";
    } catch (const Faulted& faulted) {
      EXPECT_EQ(faulted.fault(), protocol::Fault::interlock);
      EXPECT_THAT(faulted.what(),
                  HasSubstr("at row " + std::to_string(row) + ": the interlock opened"));
      EXPECT_THAT(faulted.remedy(), HasSubstr("close the enclosure"));
    }
    EXPECT_EQ(sink.safe(), row) << "what was measured before is safe";

    // Cleared by the user, the scan goes on where it was.
    session.request(protocol::ClearFault{static_cast<std::uint8_t>(protocol::Fault::interlock)});
    EXPECT_TRUE(stream.run(session));
    EXPECT_EQ(sink.safe(), 100u);
  }
}

TEST(ProgramStream, ALinkLostFaultIsClearedByTheHostThatCameBack) {
  Cable cable;
  CheckingSink sink;
  ProgramStream stream(options_for(60), row_of, sink);
  run_until(stream, cable, 20);
  cable.device.latch(protocol::Fault::link_lost);
  cable.device.clears_refused = 3;
  Session session(plug_into(cable));
  EXPECT_TRUE(stream.run(session));
  EXPECT_EQ(sink.safe(), 60u);
  EXPECT_EQ(stream.counters().link_lost_cleared, 1u);
}

TEST(ProgramStream, AFaultFoundWhenAttachingIsNotCleared) {
  Cable cable;
  cable.device.latch(protocol::Fault::stall);
  CheckingSink sink;
  ProgramStream stream(options_for(60), row_of, sink);
  Session session(plug_into(cable));
  EXPECT_THROW(stream.run(session), Faulted);
  EXPECT_EQ(cable.device.requests[protocol::ClearFault::info.id], 0);
}

TEST(ProgramStream, ARowTheDeviceCannotDoIsNamed) {
  Cable cable;
  cable.device.greatest_target_udeg = 7 * 25;
  CheckingSink sink;
  ProgramStream stream(options_for(60), row_of, sink);
  Session session(plug_into(cable));
  try {
    stream.run(session);
    FAIL() << "no error";
  } catch (const Refused& refused) {
    EXPECT_EQ(refused.refusal(), protocol::Refusal::outside_limits);
    EXPECT_THAT(refused.what(), HasSubstr("refuses row 25 of the plan: the position lies outside"));
  }
}

TEST(ProgramStream, AProgramEndedAtTheDeviceIsBegunAgainWhereItStopped) {
  Cable cable;
  CheckingSink sink;
  ProgramStream stream(options_for(60), row_of, sink);
  Session session(plug_into(cable));
  stream.attach(session);
  while (stream.next_index() < 20) stream.advance(1ms);
  cable.device.end_program();
  while (!stream.advance(1s)) {
  }
  EXPECT_EQ(sink.safe(), 60u);
}

TEST(ProgramStream, APausedScanRestsUntilItIsResumed) {
  Cable cable;
  cable.device.measure_us = 20'000;
  CheckingSink sink;
  ProgramStream stream(options_for(200), row_of, sink);
  {
    Session session(plug_into(cable));
    EXPECT_FALSE(stream.run(session, [](const ProgramStream& s) { return s.next_index() < 50; }));
    EXPECT_EQ(sink.safe(), sink.next());
    EXPECT_EQ(cable.device.status.state, static_cast<std::uint8_t>(protocol::State::paused));
  }
  const std::uint32_t measured = cable.device.status.next_record;
  cable.device.step(1'000'000);
  EXPECT_EQ(cable.device.status.next_record, measured);
  Session session(plug_into(cable));
  EXPECT_TRUE(stream.run(session));
  EXPECT_EQ(sink.safe(), 200u);
  EXPECT_EQ(stream.counters().programs_begun, 1u);
}

TEST(ProgramStream, ADeviceThatAcceptsAProgramButDoesNotRunItIsAnError) {
  Cable cable;
  cable.device.forgetful = true;
  CheckingSink sink;
  ProgramStream stream(options_for(60), row_of, sink);
  Session session(plug_into(cable));
  try {
    stream.run(session);
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(),
                HasSubstr("accepts the scan program but does not run it (it is idle)"));
  }
}

TEST(ProgramStream, ADeviceThatEndsTheProgramAgainAndAgainIsAnError) {
  Cable cable;
  CheckingSink sink;
  ProgramStream stream(options_for(60), row_of, sink);
  Session session(plug_into(cable));
  stream.attach(session);
  while (stream.next_index() < 20) stream.advance(1ms);
  cable.device.measure_us = 100'000'000;  // nothing is measured any more
  EXPECT_THROW(
      {
        for (int i = 0; i < 1000; ++i) {
          cable.device.end_program();
          stream.advance(500ms);
        }
      },
      Error);
  EXPECT_EQ(sink.safe(), sink.next());
}

TEST(ProgramStream, RecordsAreMadeSafeInBatches) {
  Cable cable;
  CheckingSink sink;
  ProgramOptions options = options_for(400);
  options.records_per_secure = 4;
  ProgramStream stream(options, row_of, sink);
  Session session(plug_into(cable));
  stream.run(session);
  EXPECT_GE(sink.secured(), 50);
  EXPECT_LE(sink.secured(), 101);
}

TEST(ProgramStream, AFullDiskEndsTheScanWithTheSinksOwnWords) {
  class FullDisk final : public RecordSink {
   public:
    void take(const protocol::Record&) override {
      if (++taken > 10) throw Error("disk full", "make room");
    }
    void secure() override { safe = taken; }
    int taken = 0;
    int safe = 0;
  } sink;
  Cable cable;
  std::uint32_t acknowledged = 0;
  cable.device.on_ack = [&](std::uint32_t next) { acknowledged = next; };
  ProgramStream stream(options_for(60), row_of, sink);
  Session session(plug_into(cable));
  EXPECT_THROW(stream.run(session), Error);
  EXPECT_LE(acknowledged, 10u) << "the record that did not fit stays in the device";
  EXPECT_EQ(stream.next_index(), 10u);
}

TEST(ProgramStream, NothingMissingMeansNothingMeasured) {
  Cable cable;
  CheckingSink sink(30);
  ProgramStream stream(options_for(30, 30), row_of, sink);
  Session session(plug_into(cable));
  EXPECT_TRUE(stream.run(session));
  EXPECT_EQ(cable.device.requests[protocol::ProgramBegin::info.id], 0);
}

TEST(ProgramStream, ImpossibleProgramsAreRefusedBeforeAnythingIsSent) {
  CheckingSink sink;
  EXPECT_THROW(ProgramStream(options_for(0), row_of, sink), Error);
  EXPECT_THROW(ProgramStream(options_for(10, 11), row_of, sink), Error);
  ProgramOptions nameless = options_for(10);
  nameless.program_id = 0;
  EXPECT_THROW(ProgramStream(nameless, row_of, sink), Error);
}

}  // namespace
}  // namespace umov::instrument
