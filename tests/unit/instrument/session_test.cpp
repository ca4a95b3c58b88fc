#include "host/instrument/session.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "host/errors/error.hpp"
#include "host/instrument/link_lost.hpp"
#include "host/instrument/refusals.hpp"
#include "tests/unit/failure.hpp"
#include "tests/unit/instrument/simulated_link.hpp"

namespace umov::instrument {
namespace {

using namespace std::chrono_literals;
using testing::Cable;
using ::testing::HasSubstr;
using testing::plug_into;

TEST(Session, TheHandshakeTellsWhoTheDeviceIs) {
  Cable cable;
  Session session(plug_into(cable));
  EXPECT_STREQ(session.device().device_name.data(), "simulated");
  EXPECT_EQ(session.device().boot_id, 1u);
  EXPECT_TRUE(session.clock().ready());
}

TEST(Session, TheHandshakeFlushesWhatACrashedHostLeftInThePipe) {
  Cable cable;
  // Half a frame, a whole record, a status and a hello_reply to somebody else's hello.
  const auto leave = [&](std::uint16_t sequence, const auto& message) {
    testing::Bytes frame(protocol::max_wire_frame_size);
    frame.resize(protocol::FrameWriter::write(sequence, message, frame));
    cable.stale.insert(cable.stale.end(), frame.begin(), frame.end());
  };
  cable.stale = {0x22, 0x81, 0x10};
  leave(5, protocol::Record{});
  protocol::HelloReply other;
  other.version = 99;
  leave(6, other);
  leave(7, protocol::Status{});
  leave(8, protocol::Busy{testing::make_name("whoever asked last")});
  // And half a frame on its way to the device.
  cable.device.receive(testing::Bytes{0x30, 0x01, 0x02});

  Session session(plug_into(cable));
  EXPECT_EQ(session.device().version, protocol::protocol_version);
  EXPECT_FALSE(session.next_event()) << "stale messages are not events";
}

TEST(Session, ADeviceOfAnotherSchemaIsRefusedNamingBoth) {
  Cable cable;
  cable.device.version = 7;
  cable.device.hash = 0xabcdef;
  const std::string text = failure_of([&] { Session session(plug_into(cable)); });
  EXPECT_THAT(text, HasSubstr("protocol version 7 (schema 0000000000abcdef)"));
  EXPECT_THAT(text, HasSubstr("this program protocol version 1 (schema "));
  EXPECT_THAT(text, HasSubstr("flash the firmware"));
}

TEST(Session, ABusyDeviceNamesItsOwner) {
  Cable cable;
  cable.device.owner = testing::make_name("lab bench 2");
  EXPECT_THAT(failure_of([&] { Session session(plug_into(cable)); }),
              HasSubstr("the controller is in use by host 'lab bench 2'"));
}

TEST(Session, ASilentDeviceIsALostLink) {
  Cable cable;
  cable.device.mute = true;
  EXPECT_THROW(Session session(plug_into(cable)), LinkLost);
  EXPECT_THAT(failure_of([&] { Session session(plug_into(cable)); }),
              HasSubstr("no answer to hello"));
}

TEST(Session, ARefusalIsAnErrorWithReasonAndRemedy) {
  Cable cable;
  Session session(plug_into(cable));
  try {
    session.request(protocol::Move{1, 30'000'000});
    FAIL() << "not refused";
  } catch (const Refused& refused) {
    EXPECT_EQ(refused.refusal(), protocol::Refusal::not_homed);
    EXPECT_THAT(refused.what(),
                HasSubstr("simulated: the controller refuses move: an axis (detector) has not"));
    EXPECT_THAT(refused.remedy(), HasSubstr("umov device home"));
  }
}

TEST(Session, AFieldOutOfRangeIsNamedAndNothingIsSent) {
  Cable cable;
  Session session(plug_into(cable));
  EXPECT_THAT(
      failure_of([&] { session.request(protocol::Home{64}); }),
      HasSubstr("the field axis_mask of the message home is out of range (allowed is 1 to 63)"));
  EXPECT_EQ(cable.device.requests[protocol::Home::info.id], 0);
}

TEST(Session, ARequestThatMayBeRepeatedSurvivesABadLine) {
  Cable cable;
  cable.faults.drop = 0.3;
  SessionOptions options;
  options.attempts = 40;
  Session session(plug_into(cable), options);
  for (int i = 0; i < 100; ++i) {
    EXPECT_EQ(session.request(protocol::GetStatus{}).program_id, 0u);
  }
  EXPECT_GT(cable.device.requests[protocol::GetStatus::info.id], 110);
}

TEST(Session, ARequestThatMustNotBeRepeatedIsSentOnce) {
  Cable cable;
  Session session(plug_into(cable));
  cable.device.mute = true;
  EXPECT_THROW(session.request(protocol::Move{1, 0}), Unanswered);
  EXPECT_EQ(cable.device.requests[protocol::Move::info.id], 1);
  EXPECT_THROW(session.request(protocol::Stop{1}), LinkLost);
  EXPECT_EQ(cable.device.requests[protocol::Stop::info.id], SessionOptions{}.attempts);
}

TEST(Session, TheHeartbeatBeatsAtLeastEvery500MsWhilePolled) {
  Cable cable;
  Session session(plug_into(cable));
  cable.device.status_times_us.clear();
  const std::uint64_t start = session.clock_us();
  while (session.clock_us() < start + 10'000'000) {
    session.poll(3s);
    while (session.next_event()) {
    }
  }
  const auto& times = cable.device.status_times_us;
  ASSERT_GE(times.size(), 20u);
  std::uint64_t last = start;
  for (const std::uint64_t time : times) {
    EXPECT_LE(time - last, 500'000u);
    last = time;
  }
  EXPECT_TRUE(session.latest_status());
}

TEST(Session, EventsThatArriveDuringARequestAreKeptInOrder) {
  Cable cable;
  Session session(plug_into(cable));
  cable.device.latch(protocol::Fault::interlock);
  session.request(protocol::GetStatus{});
  const auto event = session.next_event();
  ASSERT_TRUE(event);
  ASSERT_TRUE(std::holds_alternative<protocol::FaultEvent>(*event));
  EXPECT_FALSE(session.next_event());
}

TEST(Session, PollReturnsAtItsTimeoutWhenNothingHappens) {
  Cable cable;
  Session session(plug_into(cable));
  const std::uint64_t start = session.clock_us();
  EXPECT_FALSE(session.poll(50ms));
  EXPECT_GE(session.clock_us(), start + 50'000);
  EXPECT_LE(session.clock_us(), start + 60'000);
}

TEST(Session, ADeviceThatWasRestartedIsALostLink) {
  Cable cable;
  Session session(plug_into(cable));
  cable.device.restart();
  EXPECT_THAT(failure_of([&] {
                while (true) session.poll(1s);
              }),
              HasSubstr("the controller was restarted"));
}

TEST(Session, ARequestToADeviceThatWasRestartedIsALostLinkNotARefusal) {
  Cable cable;
  Session session(plug_into(cable));
  cable.device.restart();
  try {
    session.request(protocol::GetStatus{});
    FAIL() << "answered";
  } catch (const LinkLost& lost) {
    EXPECT_THAT(lost.what(), HasSubstr("the controller was restarted"));
  }
}

TEST(Session, TheDeviceClockIsKnownWithinItsUncertainty) {
  Cable cable;
  cable.device.clock_rate = 1.00005;
  cable.device.clock_offset_us = 77'000'000;
  cable.one_way_us = 200;
  cable.jitter_us = 3000;
  Session session(plug_into(cable));
  const std::uint64_t start = session.clock_us();
  while (session.clock_us() < start + 100'000'000) {
    session.poll(1s);
    while (session.next_event()) {
    }
  }
  const double host_now = static_cast<double>(session.clock_us());
  const double device_now = 77e6 + std::floor(1.00005 * host_now);
  const double miss = session.clock().host_time_us(device_now) - host_now;
  const double u = session.clock().uncertainty_us(device_now);
  EXPECT_LT(u, 600.0);
  EXPECT_LT(std::abs(miss), 3 * u);
  EXPECT_NEAR(session.clock().rate(), 1 / 1.00005, 2e-5);
}

}  // namespace
}  // namespace umov::instrument
