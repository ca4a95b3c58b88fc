// The control endpoint: every length asked for, refusals, broken orders, resets.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "firmware/core/usb/descriptors.hpp"
#include "tests/unit/usb/usb_bench.hpp"

namespace umov::test {
namespace {

using ::testing::ElementsAre;
using usbip::Handshake;
using usbip::Packet;

TEST(UsbControl, any_length_asked_for_gives_the_beginning_of_the_descriptor) {
  UsbBench bench;
  const Bytes whole(fu::configuration.begin(), fu::configuration.end());
  for (std::uint16_t length = 1; length <= whole.size() + 70; ++length) {
    const Outcome outcome = bench.control({0x80, 6, 0x0200, 0, length});
    ASSERT_TRUE(outcome.ok()) << length;
    const auto size = std::min<std::size_t>(length, whole.size());
    ASSERT_EQ(outcome.bytes,
              Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)))
        << length;
  }
}

/// Sizes of the packets of the data stage, read one by one.
std::vector<std::size_t> packets(UsbBench& bench, const SetupFields& setup) {
  std::vector<std::size_t> sizes;
  EXPECT_EQ(bench.port.setup(setup.bytes()), Handshake::ack);
  Packet packet;
  while (bench.port.in(0, packet) == Handshake::ack) sizes.push_back(packet.size);
  EXPECT_EQ(bench.port.out(0, {}), Handshake::ack) << "status stage";
  return sizes;
}

/// Answers with so many bytes whatever it is asked.
class FixedReply final : public fu::PortEvents, public fu::ControlHandler {
 public:
  FixedReply(usbip::StackPort& port, std::size_t size) : pipe_(port, *this), data_(size, 0x5a) {
    port.bind(*this);
    port.connect();
    port.bus_reset();
  }
  void on_reset() override { pipe_.reset(); }
  void on_suspend() override {}
  void on_resume() override {}
  void on_setup(const fu::SetupPacket& packet) override { pipe_.on_setup(packet); }
  void on_sent(fu::EndpointAddress) override { pipe_.on_sent(); }
  void on_received(fu::EndpointAddress, std::size_t size) override { pipe_.on_received(size); }
  fu::ControlAnswer on_request(const fu::Request&) override {
    return fu::ControlAnswer::reply(data_);
  }
  bool on_data(const fu::Request&, std::span<const std::uint8_t>) override { return false; }
  void on_complete(const fu::Request&) override { ++completed; }
  int completed = 0;

 private:
  fu::ControlPipe pipe_;
  Bytes data_;
};

TEST(UsbControl, a_reply_shorter_than_asked_ends_with_a_short_packet) {
  const auto sizes = [](std::size_t reply, std::uint16_t asked) {
    usbip::StackPort port;
    FixedReply device(port, reply);
    EXPECT_EQ(port.setup(SetupFields{0x80, 1, 0, 0, asked}.bytes()), Handshake::ack);
    std::vector<std::size_t> found;
    Packet packet;
    while (port.in(0, packet) == Handshake::ack) found.push_back(packet.size);
    EXPECT_EQ(port.out(0, {}), Handshake::ack);
    EXPECT_EQ(device.completed, 1);
    return found;
  };
  EXPECT_THAT(sizes(128, 128), ElementsAre(64, 64)) << "the host knows that this is all";
  EXPECT_THAT(sizes(128, 200), ElementsAre(64, 64, 0));
  EXPECT_THAT(sizes(64, 65), ElementsAre(64, 0));
  EXPECT_THAT(sizes(100, 200), ElementsAre(64, 36));
  EXPECT_THAT(sizes(300, 64), ElementsAre(64));
  EXPECT_THAT(sizes(0, 10), ElementsAre(0));
}

TEST(UsbControl, a_request_for_no_bytes_goes_straight_to_the_status_stage) {
  UsbBench bench;
  EXPECT_THAT(packets(bench, {0x80, 6, 0x0100, 0, 8}), ElementsAre(8));
  const Outcome outcome = bench.control({0x80, 6, 0x0100, 0, 0});
  EXPECT_TRUE(outcome.ok());
  EXPECT_TRUE(outcome.bytes.empty());
}

TEST(UsbControl, what_is_not_known_is_stalled_until_the_next_setup) {
  UsbBench bench;
  const std::vector<SetupFields> unknown = {
      {0x80, 6, 0x0600, 0, 10},   // device qualifier: full speed only
      {0x80, 6, 0x0201, 0, 9},    // a second configuration
      {0x80, 6, 0x0309, 0, 255},  // string 9
      {0x80, 6, 0x0000, 0, 8},    // descriptor type 0
      {0x00, 9, 2, 0, 0},         // configuration 2
      {0x00, 9, 1, 0, 4},         // a configuration with a data stage
      {0x00, 3, 1, 0, 0},         // remote wake-up
      {0x00, 7, 0x0100, 0, 18},   // SET_DESCRIPTOR
      {0x82, 12, 0, 0x81, 2},     // SYNCH_FRAME
      {0x80, 0x77, 0, 0, 1},      // no such standard request
      {0xc0, 1, 0, 4, 100},       // Microsoft's older descriptors
      {0x40, 9, 0, 0, 0},         // vendor, unknown
      {0xe0, 0, 0, 0, 1},         // reserved type
      {0x21, 9, 0x0200, 1, 64},   // a report before the device is configured
      {0xa1, 1, 0x0100, 2, 8},    // the same
      {0x81, 10, 0, 0, 1},        // GET_INTERFACE before that
  };
  for (const SetupFields& setup : unknown) {
    const Outcome outcome = bench.control(setup, Bytes(setup.type & 0x80 ? 0 : setup.length));
    EXPECT_TRUE(outcome.stalled()) << int{setup.type} << " " << int{setup.request};
    EXPECT_EQ(bench.control({0x80, 6, 0x0100, 0, 18}).bytes.size(), 18u) << "the next one is good";
  }
}

TEST(UsbControl, chapter_nine_by_the_book) {
  UsbBench bench;
  EXPECT_TRUE(bench.control({0x00, 5, 23, 0, 0}).ok());
  EXPECT_EQ(bench.port.address(), 23);
  EXPECT_THAT(bench.control({0x80, 8, 0, 0, 1}).bytes, ElementsAre(0)) << "not configured";
  EXPECT_TRUE(bench.configure().ok());
  EXPECT_TRUE(bench.device.configured());
  EXPECT_THAT(bench.control({0x80, 8, 0, 0, 1}).bytes, ElementsAre(1));
  EXPECT_THAT(bench.control({0x80, 0, 0, 0, 2}).bytes, ElementsAre(1, 0)) << "self-powered";
  EXPECT_THAT(bench.control({0x81, 0, 0, 3, 2}).bytes, ElementsAre(0, 0));
  EXPECT_TRUE(bench.control({0x81, 0, 0, 4, 2}).stalled()) << "no fifth interface";
  EXPECT_THAT(bench.control({0x81, 10, 0, 2, 1}).bytes, ElementsAre(0));
  EXPECT_TRUE(bench.control({0x01, 11, 0, 1, 0}).ok());
  EXPECT_TRUE(bench.control({0x01, 11, 1, 1, 0}).stalled()) << "no alternate settings";
  // Halt of an endpoint, and its end.
  EXPECT_TRUE(bench.control({0x02, 3, 0, 0x81, 0}).ok());
  EXPECT_THAT(bench.control({0x82, 0, 0, 0x81, 2}).bytes, ElementsAre(1, 0));
  EXPECT_TRUE(bench.read(1, 64).value().stalled());
  EXPECT_TRUE(bench.control({0x02, 1, 0, 0x81, 0}).ok());
  EXPECT_THAT(bench.control({0x82, 0, 0, 0x81, 2}).bytes, ElementsAre(0, 0));
  EXPECT_FALSE(bench.read(1, 64).has_value()) << "nothing to say, but no stall";
  EXPECT_TRUE(bench.control({0x02, 3, 0, 0x84, 0}).stalled()) << "no such endpoint";
  // Back to the address state.
  EXPECT_TRUE(bench.configure(0).ok());
  EXPECT_EQ(bench.port.out(1, {}), Handshake::none) << "endpoints are closed";
  EXPECT_TRUE(bench.configure().ok());
  EXPECT_TRUE(bench.write(1, counting_bytes(10)).ok());
}

TEST(UsbControl, a_new_setup_ends_what_was_under_way) {
  UsbBench bench;
  bench.configure();
  const auto ask = SetupFields{0x80, 6, 0x0200, 0, 255}.bytes();
  const auto report = SetupFields{0x21, 9, 0x0200, 1, 64}.bytes();
  const auto detach = SetupFields{0x21, 0, 1000, 3, 0}.bytes();
  Packet packet;
  // In mid data stage to the host.
  ASSERT_EQ(bench.port.setup(ask), Handshake::ack);
  ASSERT_EQ(bench.port.in(0, packet), Handshake::ack);
  // Before the data stage from the host.
  ASSERT_EQ(bench.port.setup(report), Handshake::ack);
  ASSERT_EQ(bench.port.setup(report), Handshake::ack);
  // Before the status stage of a request: it is not carried out.
  ASSERT_EQ(bench.port.setup(detach), Handshake::ack);
  ASSERT_EQ(bench.port.setup(ask), Handshake::ack);
  EXPECT_EQ(bench.application.detaches, 0);
  EXPECT_TRUE(bench.application.received.empty());
  const Outcome outcome = bench.control({0x80, 6, 0x0100, 0, 18});
  EXPECT_EQ(outcome.bytes.size(), 18u);
}

TEST(UsbControl, a_host_may_end_the_data_stage_early) {
  UsbBench bench;
  Packet packet;
  ASSERT_EQ(bench.port.setup(SetupFields{0x80, 6, 0x0200, 0, 255}.bytes()), Handshake::ack);
  ASSERT_EQ(bench.port.in(0, packet), Handshake::ack);
  EXPECT_EQ(bench.port.out(0, {}), Handshake::ack);
  EXPECT_EQ(bench.control({0x80, 6, 0x0100, 0, 18}).bytes.size(), 18u);
}

TEST(UsbControl, stages_out_of_turn_do_no_harm) {
  UsbBench bench;
  bench.configure();
  Packet packet;
  EXPECT_NE(bench.port.in(0, packet), Handshake::ack) << "data nobody asked for";
  EXPECT_NE(bench.port.out(0, counting_bytes(8)), Handshake::ack);
  // Data in the status stage.
  ASSERT_EQ(bench.port.setup(SetupFields{0x80, 6, 0x0100, 0, 18}.bytes()), Handshake::ack);
  ASSERT_EQ(bench.port.in(0, packet), Handshake::ack);
  EXPECT_EQ(bench.port.out(0, counting_bytes(8)), Handshake::stall);
  // A data stage from the host that ends before it should.
  ASSERT_EQ(bench.port.setup(SetupFields{0x21, 9, 0x0200, 1, 64}.bytes()), Handshake::ack);
  EXPECT_EQ(bench.port.out(0, counting_bytes(20)), Handshake::ack);
  EXPECT_EQ(bench.port.in(0, packet), Handshake::stall);
  EXPECT_TRUE(bench.application.received.empty());
  EXPECT_EQ(bench.control({0x80, 6, 0x0100, 0, 18}).bytes.size(), 18u);
}

TEST(UsbControl, a_reset_in_mid_transfer_starts_from_nothing) {
  UsbBench bench;
  Packet packet;
  for (int stage = 0; stage < 4; ++stage) {
    bench.configure();
    const bool from_host = stage >= 2;
    const auto setup =
        from_host ? SetupFields{0x21, 9, 0x0200, 1, 64} : SetupFields{0x80, 6, 0x0200, 0, 255};
    ASSERT_EQ(bench.port.setup(setup.bytes()), Handshake::ack);
    if (stage == 1) {
      ASSERT_EQ(bench.port.in(0, packet), Handshake::ack);
    }
    if (stage == 3) {
      ASSERT_EQ(bench.port.out(0, counting_bytes(64)), Handshake::ack);
    }
    bench.port.bus_reset();
    EXPECT_FALSE(bench.device.configured());
    EXPECT_EQ(bench.port.address(), 0);
    EXPECT_EQ(bench.port.in(0, packet), Handshake::nak) << stage;
    EXPECT_EQ(bench.control({0x80, 6, 0x0100, 0, 18}).bytes.size(), 18u) << stage;
  }
}

TEST(UsbControl, detach_is_told_after_the_host_has_its_answer) {
  UsbBench bench;
  bench.configure();
  EXPECT_THAT(bench.control({0xa1, 5, 0, 3, 1}).bytes, ElementsAre(0)) << "appIDLE";
  ASSERT_EQ(bench.port.setup(SetupFields{0x21, 0, 1000, 3, 0}.bytes()), Handshake::ack);
  EXPECT_EQ(bench.application.detaches, 0);
  Packet packet;
  ASSERT_EQ(bench.port.in(0, packet), Handshake::ack);
  EXPECT_EQ(bench.application.detaches, 1);
  EXPECT_THAT(bench.control({0xa1, 3, 0, 3, 6}).bytes, ElementsAre(0, 0, 0, 0, 1, 0))
      << "appDETACH";
}

TEST(UsbControl, detach_is_refused_where_the_program_must_not_end) {
  UsbBench bench;
  bench.configure();
  bench.application.may_detach = false;
  EXPECT_TRUE(bench.control({0x21, 0, 1000, 3, 0}).stalled());
  EXPECT_EQ(bench.application.detaches, 0);
  EXPECT_THAT(bench.control({0xa1, 5, 0, 3, 1}).bytes, ElementsAre(0)) << "still appIDLE";
}

}  // namespace
}  // namespace umov::test
