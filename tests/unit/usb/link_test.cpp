// The protocol's bytes over bulk pipes and HID reports, and who owns them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "protocol/codec.hpp"
#include "tests/unit/usb/usb_bench.hpp"

namespace umov::test {
namespace {

using protocol::Busy;
using protocol::Hello;
using ::testing::ElementsAre;

class UsbLink : public ::testing::Test {
 protected:
  UsbLink() { bench.configure(); }

  void open_on_bulk(const std::string& host = "first") { write_all(1, hello_frame(host)); }
  /// As a host does: in transfers of any length, or in whole reports.
  void write_all(std::uint8_t endpoint, Bytes bytes) {
    if (endpoint == 2) bytes.resize((bytes.size() + 63) / 64 * 64);
    EXPECT_TRUE(bench.write(endpoint, std::move(bytes)).ok());
  }
  Bytes read_all(std::uint8_t endpoint, std::size_t length) {
    Bytes all;
    while (const auto outcome = bench.read(endpoint, length)) {
      EXPECT_TRUE(outcome->ok());
      all.insert(all.end(), outcome->bytes.begin(), outcome->bytes.end());
    }
    return all;
  }

  UsbBench bench;
};

TEST_F(UsbLink, nothing_is_passed_on_before_a_host_greets) {
  write_all(1, counting_bytes(200));
  EXPECT_TRUE(bench.application.received.empty());
  open_on_bulk();
  EXPECT_THAT(frame_types(bench.application.received), ElementsAre(Hello::info.id));
  write_all(1, counting_bytes(300));
  const Bytes& received = bench.application.received;
  EXPECT_EQ(Bytes(received.end() - 300, received.end()), counting_bytes(300));
}

TEST_F(UsbLink, what_follows_the_greeting_in_the_same_packet_is_not_lost) {
  Bytes bytes = hello_frame("first");
  const Bytes more = counting_bytes(64 - bytes.size() % 64 + 30);
  bytes.insert(bytes.end(), more.begin(), more.end());
  write_all(1, bytes);
  const Bytes& received = bench.application.received;
  ASSERT_GT(received.size(), more.size());
  EXPECT_EQ(Bytes(received.end() - static_cast<std::ptrdiff_t>(more.size()), received.end()), more);
}

TEST_F(UsbLink, every_length_arrives_and_ends_a_long_read) {
  open_on_bulk();
  for (std::size_t size = 1; size <= 1200; size += size < 140 ? 1 : 53) {
    const Bytes bytes = counting_bytes(size);
    ASSERT_TRUE(bench.device.write_link(bytes));
    Bytes read;
    while (const auto outcome = bench.read(1, 4096)) {
      ASSERT_TRUE(outcome->ok()) << size;
      read.insert(read.end(), outcome->bytes.begin(), outcome->bytes.end());
    }
    // Each read above ended although 4096 bytes were asked for: by a short packet or, at whole
    // multiples of 64, by an empty one.
    ASSERT_EQ(read, bytes) << size;
  }
}

TEST_F(UsbLink, a_full_packet_is_followed_by_an_empty_one_only_when_nothing_follows) {
  open_on_bulk();
  bench.device.write_link(counting_bytes(128));
  usbip::Packet packet;
  std::vector<std::size_t> sizes;
  while (bench.port.in(1, packet) == usbip::Handshake::ack) sizes.push_back(packet.size);
  EXPECT_THAT(sizes, ElementsAre(64, 64, 0));
  sizes.clear();
  bench.device.write_link(counting_bytes(512));
  bench.device.write_link(counting_bytes(70));
  while (bench.port.in(1, packet) == usbip::Handshake::ack) sizes.push_back(packet.size);
  EXPECT_THAT(sizes, ElementsAre(64, 64, 64, 64, 64, 64, 64, 64, 64, 6));
}

TEST_F(UsbLink, a_host_that_does_not_read_fills_the_ring_and_nothing_is_lost) {
  open_on_bulk();
  Bytes sent;
  std::uint8_t first = 1;
  for (;;) {
    const Bytes frame = counting_bytes(100, first++);
    const bool fits = bench.device.link_room() >= frame.size();
    EXPECT_EQ(bench.device.write_link(frame), fits);
    if (!fits) break;
    sent.insert(sent.end(), frame.begin(), frame.end());
  }
  EXPECT_GE(sent.size(), 4000u);
  EXPECT_EQ(read_all(1, 512), sent);
  EXPECT_EQ(bench.device.link_room(), 4096u);
}

TEST_F(UsbLink, reports_are_always_64_bytes_padded_with_empty_frames) {
  write_all(2, hello_frame("by hid"));
  EXPECT_THAT(frame_types(bench.application.received), ElementsAre(Hello::info.id));
  bench.device.write_link(counting_bytes(70));
  const auto one = bench.read(2, 64);
  const auto two = bench.read(2, 64);
  ASSERT_TRUE(one && two);
  EXPECT_EQ(one->bytes, counting_bytes(64));
  Bytes rest = counting_bytes(6, 65);
  rest.resize(64);
  EXPECT_EQ(two->bytes, rest);
  EXPECT_FALSE(bench.read(2, 64).has_value());
}

TEST_F(UsbLink, a_report_may_come_through_the_control_endpoint) {
  Bytes report = hello_frame("control");
  report.resize(64);
  EXPECT_TRUE(bench.control({0x21, 9, 0x0200, 1, 64}, report).ok());
  EXPECT_THAT(frame_types(bench.application.received), ElementsAre(Hello::info.id));
  EXPECT_TRUE(bench.control({0x21, 9, 0x0200, 1, 63}, Bytes(63)).stalled()) << "not a report";
  EXPECT_TRUE(bench.control({0x21, 9, 0x0300, 1, 64}, report).stalled())
      << "a feature report of that length";
  EXPECT_TRUE(bench.control({0xa1, 1, 0x0100, 1, 64}).stalled()) << "no stream over GET_REPORT";
}

TEST_F(UsbLink, a_second_host_is_told_who_has_the_controller) {
  bench.device.tick(1'000'000);
  open_on_bulk("optics-lab-2");
  bench.device.write_link(counting_bytes(300));
  bench.device.tick(1'900'000);
  write_all(2, hello_frame("second", 77));
  const Bytes answer = read_all(2, 64);
  protocol::FrameReader reader;
  int answers = 0;
  reader.feed(answer, [&](const protocol::FrameView& frame) {
    ++answers;
    EXPECT_EQ(frame.type, Busy::info.id);
    EXPECT_EQ(frame.sequence, 77);
    Busy busy;
    ASSERT_TRUE(protocol::decode(frame.payload, busy).ok());
    EXPECT_STREQ(busy.owner.data(), "optics-lab-2");
  });
  EXPECT_EQ(answers, 1);
  EXPECT_EQ(read_all(1, 4096), counting_bytes(300)) << "the first one is not disturbed";
  EXPECT_EQ(frame_types(bench.application.received).size(), 1u);
}

TEST_F(UsbLink, an_owner_that_has_fallen_silent_or_says_good_bye_makes_room) {
  bench.device.tick(1'000'000);
  open_on_bulk();
  bench.device.tick(2'600'000);
  write_all(2, hello_frame("second"));
  EXPECT_EQ(frame_types(bench.application.received).size(), 2u);
  bench.device.write_link(counting_bytes(10));
  EXPECT_TRUE(read_all(1, 64).empty());
  EXPECT_EQ(read_all(2, 64).size(), 64u);

  bench.device.tick(9'000'000);
  open_on_bulk();
  EXPECT_EQ(frame_types(bench.application.received).size(), 3u);
  EXPECT_TRUE(bench.control({0x41, 2, 0, 0, 0}).ok());
  write_all(2, hello_frame("third"));
  EXPECT_EQ(frame_types(bench.application.received).size(), 4u);
  EXPECT_TRUE(bench.control({0x21, 9, 0x0300, 1, 1}, {0}).ok());
  open_on_bulk("fourth");
  EXPECT_EQ(frame_types(bench.application.received).size(), 5u);
}

/// A serial line that keeps what is written to it.
class KeptLine final : public fu::SerialLine {
 public:
  std::size_t room() const override { return 1000 - sent.size(); }
  bool write(std::span<const std::uint8_t> bytes) override {
    if (bytes.size() > room()) return false;
    sent.insert(sent.end(), bytes.begin(), bytes.end());
    return true;
  }
  Bytes sent;
};

TEST(SerialLine, a_host_on_it_keeps_the_link_when_another_greets_on_usb) {
  KeptLine line;
  UsbBench bench("TEST-2", &line);
  bench.configure();
  bench.device.tick(1'000'000);
  bench.device.take_serial(hello_frame("on the line"));
  EXPECT_THAT(frame_types(bench.application.received), ElementsAre(Hello::info.id));
  EXPECT_TRUE(bench.device.write_link(counting_bytes(30)));
  EXPECT_EQ(line.sent, counting_bytes(30));
  EXPECT_EQ(bench.device.link_room(), 970u);
  bench.device.tick(1'900'000);
  EXPECT_TRUE(bench.write(1, hello_frame("on usb", 5)).ok());
  const auto refused = bench.read(1, 64);
  ASSERT_TRUE(refused.has_value());
  Busy busy;
  protocol::FrameReader reader;
  reader.feed(refused->bytes, [&](const protocol::FrameView& frame) {
    EXPECT_EQ(frame.sequence, 5);
    EXPECT_TRUE(protocol::decode(frame.payload, busy).ok());
  });
  EXPECT_STREQ(busy.owner.data(), "on the line");
  bench.port.bus_reset();
  EXPECT_TRUE(bench.device.write_link(counting_bytes(5))) << "the cable is none of its business";
  EXPECT_EQ(frame_types(bench.application.received).size(), 1u);
}

TEST(SerialLine, a_host_on_it_is_told_who_is_on_usb) {
  KeptLine line;
  UsbBench bench("TEST-3", &line);
  bench.configure();
  bench.device.tick(1'000'000);
  EXPECT_TRUE(bench.write(1, hello_frame("on usb")).ok());
  bench.device.take_serial(hello_frame("late", 9));
  EXPECT_THAT(frame_types(line.sent), ElementsAre(Busy::info.id));
  EXPECT_THAT(frame_types(bench.application.received), ElementsAre(Hello::info.id));
  bench.device.tick(2'600'000);
  bench.device.take_serial(hello_frame("late", 10));
  EXPECT_EQ(frame_types(bench.application.received).size(), 2u) << "usb has fallen silent";
}

TEST_F(UsbLink, frames_for_nobody_are_not_taken) {
  EXPECT_EQ(bench.device.link_room(), 0u);
  EXPECT_FALSE(bench.device.write_link(counting_bytes(10)));
}

TEST_F(UsbLink, a_host_from_before_a_restart_is_told_to_greet) {
  Bytes frame(protocol::wire_frame_size<protocol::GetStatus>);
  frame.resize(protocol::FrameWriter::write(3, protocol::GetStatus{}, frame));
  write_all(1, frame);
  EXPECT_THAT(frame_types(read_all(1, 64)), ElementsAre(protocol::ErrorReply::info.id));
  EXPECT_TRUE(bench.application.received.empty());
}

TEST_F(UsbLink, an_unplugged_cable_leaves_no_stale_bytes) {
  open_on_bulk();
  bench.device.write_link(counting_bytes(3000));
  usbip::Packet packet;
  ASSERT_EQ(bench.port.in(1, packet), usbip::Handshake::ack);
  write_all(1, counting_bytes(10));
  bench.port.bus_reset();
  EXPECT_FALSE(bench.device.write_link(counting_bytes(100))) << "nobody there";
  bench.configure();
  EXPECT_FALSE(bench.read(1, 64).has_value());
  bench.application.received.clear();
  open_on_bulk();
  EXPECT_THAT(frame_types(bench.application.received), ElementsAre(Hello::info.id));
  bench.device.write_link(counting_bytes(20));
  EXPECT_EQ(read_all(1, 64), counting_bytes(20));
}

TEST_F(UsbLink, a_halt_that_is_cleared_leaves_both_directions_working) {
  open_on_bulk();
  for (const std::uint8_t endpoint : {fu::bulk_in, fu::bulk_out}) {
    bench.device.write_link(counting_bytes(30));
    EXPECT_TRUE(bench.control({0x02, 3, 0, endpoint, 0}).ok());
    EXPECT_TRUE((endpoint == 0x81 ? bench.read(1, 64).value() : bench.write(1, {1, 2})).stalled());
    bench.device.tick(1);
    EXPECT_TRUE(bench.control({0x02, 1, 0, endpoint, 0}).ok());
    read_all(1, 64);
    bench.device.write_link(counting_bytes(40));
    EXPECT_EQ(read_all(1, 64), counting_bytes(40));
    bench.application.received.clear();
    write_all(1, counting_bytes(50));
    EXPECT_EQ(bench.application.received, counting_bytes(50));
  }
}

TEST_F(UsbLink, nothing_is_sent_on_a_halted_endpoint) {
  bench.device.tick(1'000'000);
  open_on_bulk("owner");
  EXPECT_TRUE(bench.control({0x02, 3, 0, fu::reports_in, 0}).ok());
  write_all(2, hello_frame("second"));  // would be answered with busy
  EXPECT_TRUE(bench.read(2, 64).value().stalled());
  EXPECT_TRUE(bench.control({0x02, 3, 0, fu::bulk_in, 0}).ok());
  bench.device.write_link(counting_bytes(30));
  bench.device.tick(1'001'000);
  EXPECT_TRUE(bench.read(1, 64).value().stalled());
  EXPECT_TRUE(bench.control({0x02, 1, 0, fu::bulk_in, 0}).ok());
  EXPECT_EQ(read_all(1, 64), counting_bytes(30));
}

TEST_F(UsbLink, a_hand_controller_is_shown_what_changes_and_heard) {
  bench.application.state = {
      .state = 2, .fault = 0, .homed_mask = 0x3f, .axis = 0, .position_udeg = -1'500'000};
  bench.device.tick(1000);
  auto shown = bench.read(3, 8);
  ASSERT_TRUE(shown.has_value());
  EXPECT_THAT(shown->bytes, ElementsAre(2, 0, 0x3f, 0, 0xa0, 0x1c, 0xe9, 0xff));
  bench.device.tick(2000);
  EXPECT_FALSE(bench.read(3, 8).has_value()) << "nothing new";

  EXPECT_TRUE(bench.control({0x21, 9, 0x0200, 2, 8}, {1, 0, 0, 0, 0x40, 0x42, 0x0f, 0}).ok());
  EXPECT_TRUE(bench.control({0x21, 9, 0x0200, 2, 8}, {1, 2, 0, 0, 0, 0, 0, 0}).ok());
  EXPECT_TRUE(bench.control({0x21, 9, 0x0200, 2, 8}, {6, 0, 0, 0, 1, 0, 0, 0}).stalled())
      << "no seventh axis";
  ASSERT_EQ(bench.application.hand_reports.size(), 2u);
  EXPECT_EQ(bench.application.hand_reports[0].axis, 1);
  EXPECT_EQ(bench.application.hand_reports[0].by_udeg, 1'000'000);
  EXPECT_TRUE(bench.application.hand_reports[1].emergency);
  bench.device.tick(3000);
  shown = bench.read(3, 8);
  ASSERT_TRUE(shown.has_value()) << "the axis it named last";
  EXPECT_EQ(shown->bytes.at(3), 1);
  EXPECT_EQ(bench.control({0xa1, 1, 0x0100, 2, 8}).bytes.at(3), 1) << "also when asked";
}

}  // namespace
}  // namespace umov::test
