// The flashed image at its USB connector: enumeration, the protocol over bulk pipes and reports,
// halts, resets in mid-transfer.
#include <gtest/gtest.h>

#include "boards/native/native_board.hpp"
#include "firmware/core/usb/descriptors.hpp"
#include "hil/mcu/board/mcu_board.hpp"
#include "protocol/codec.hpp"
#include "protocol/schema.hpp"
#include "tests/unit/failure.hpp"
#include "tests/unit/mcu_board/noisy_stages.hpp"
#include "tests/unit/mcu_board/scan_run.hpp"
#include "tests/unit/mcu_board/usb_cable.hpp"

namespace umov {
namespace {

namespace fu = firmware::usb;
using test::Bytes;

class UsbOfTheBoard : public testing::Test {
 protected:
  void SetUp() override {
    board_.run_for(40'000);
    ASSERT_TRUE(cable_.plug_in());
  }
  std::unique_ptr<instrument::Transport> bulk() {
    return std::make_unique<test::BulkTransport>(board_, cable_);
  }
  static std::vector<protocol::ProgramRow> rows(std::uint32_t count) {
    std::vector<protocol::ProgramRow> rows;
    for (std::uint32_t i = 0; i < count; ++i) {
      rows.push_back(
          {.index = i, .target_udeg = {}, .laser = 1, .shutter_open = 1, .gain = 0, .dwell_ms = 4});
      rows.back().target_udeg[1] = static_cast<std::int32_t>(i % 7) * 10'000;
    }
    return rows;
  }

  test::NoisyBench bench_;
  mcu::McuBoard board_{bench_, {.image = UMOV_STM32F407_ELF}};
  test::UsbCable cable_{board_};
};

TEST_F(UsbOfTheBoard, DescribesItselfInAnyLengthAskedFor) {
  const Bytes device(fu::device_descriptor.begin(), fu::device_descriptor.end());
  EXPECT_EQ(cable_.control(0x80, 6, 0x0100, 0, 64).bytes, device);
  const Bytes whole(fu::configuration.begin(), fu::configuration.end());
  constexpr std::array<std::uint16_t, 10> lengths = {1, 8, 9, 63, 64, 65, 127, 128, 129, 255};
  for (const std::uint16_t length : lengths) {
    const auto outcome = cable_.control(0x80, 6, 0x0200, 0, length);
    ASSERT_TRUE(outcome.ok()) << length;
    const auto size = std::min<std::size_t>(length, whole.size());
    EXPECT_EQ(outcome.bytes,
              Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)))
        << length;
  }
  const auto serial = cable_.control(0x80, 6, 0x0303, 0x0409, 255);
  std::string text;
  for (std::size_t i = 2; i < serial.bytes.size(); i += 2)
    text.push_back(static_cast<char>(serial.bytes[i]));
  EXPECT_EQ(text, "333137363234510A00300041") << "the chip's number";
}

TEST_F(UsbOfTheBoard, RefusesWhatItDoesNotKnowAndGoesOn) {
  EXPECT_EQ(cable_.control(0x80, 6, 0x0600, 0, 10).status, usbip::urb_status::stalled);
  EXPECT_EQ(cable_.control(0x40, 0x77, 0, 0, 0).status, usbip::urb_status::stalled);
  EXPECT_TRUE(cable_.control(0x80, 0, 0, 0, 2).ok()) << "GET_STATUS";
}

TEST_F(UsbOfTheBoard, AnotherRequestOrAResetEndsAControlTransferAnywhere) {
  const std::array<std::uint8_t, 8> ask = {0x80, 6, 0, 2, 0, 0, 255, 0};  // to the host
  const std::array<std::uint8_t, 8> tell = {0x21, 9, 0, 2, 1, 0, 64, 0};  // from the host
  auto& usb = board_.usb();
  for (int packets = 0; packets < 4; ++packets) {
    for (const bool reset : {false, true}) {
      ASSERT_EQ(usb.setup(ask), usbip::Handshake::ack);
      usbip::Packet packet;
      for (int i = 0; i < packets; ++i) {
        board_.run_for(200);
        usb.in(0, packet);
      }
      if (packets == 2) board_.run_for(200);  // the next packet waits to be fetched
      if (reset) {
        ASSERT_TRUE(cable_.plug_in());
      }
      ASSERT_TRUE(cable_.control(0x80, 6, 0x0100, 0, 18).ok()) << packets << reset;

      ASSERT_EQ(usb.setup(tell), usbip::Handshake::ack);
      if (packets > 0) board_.run_for(200);
      if (packets > 1) usb.out(0, packet.bytes);
      if (packets > 2) board_.run_for(200);
      if (reset) {
        ASSERT_TRUE(cable_.plug_in());
      }
      ASSERT_TRUE(cable_.control(0x80, 6, 0x0100, 0, 18).ok()) << packets << reset;
    }
  }
  instrument::Session session(bulk());
  EXPECT_EQ(session.request(protocol::GetStatus{}).fault, 0);
}

TEST_F(UsbOfTheBoard, AScanOverBulkGivesTheRecordsOfTheNativeBoard) {
  test::NoisyWorld world;
  boards::native::NativeBoard native_board(world);
  const auto native = test::run_rows(test::connect(native_board), rows(40));
  const auto flashed = test::run_rows(bulk(), rows(40));
  ASSERT_EQ(flashed.size(), native.size());
  for (std::size_t i = 0; i < native.size(); ++i) {
    protocol::Record a = flashed[i], b = native[i];
    a.time_us = b.time_us = 0;
    Bytes one(protocol::wire_size<protocol::Record>), other(one.size());
    ASSERT_TRUE(protocol::encode(a, one).ok() && protocol::encode(b, other).ok());
    EXPECT_EQ(one, other) << i;
  }
}

TEST(UsbOfABootableBoard, AStatusStageIsNotLostToARequestThatFollowsAtOnce) {
  test::NoisyBench bench;
  mcu::McuBoard board(bench, {.image = UMOV_STM32F407_ELF, .boot_loader = UMOV_STM32F407_BOOT_ELF});
  for (int i = 0; i < 100 && !board.usb_connected(); ++i) board.run_for(10'000);
  test::UsbCable cable(board);
  ASSERT_TRUE(cable.plug_in());
  const unsigned before = board.chip().software_resets();
  const std::array<std::uint8_t, 8> detach = {0x21, 0, 0xE8, 3, fu::interface::dfu, 0, 0, 0};
  const std::array<std::uint8_t, 8> get_status = {0x80, 0, 0, 0, 0, 0, 2, 0};
  auto& usb = board.usb();
  ASSERT_EQ(usb.setup(detach), usbip::Handshake::ack);
  board.run_for(500);
  usbip::Packet packet;
  ASSERT_EQ(usb.in(0, packet), usbip::Handshake::ack) << "the status stage";
  ASSERT_EQ(usb.setup(get_status), usbip::Handshake::ack) << "before the program has looked";
  board.run_for(20'000);
  EXPECT_EQ(board.chip().software_resets(), before + 1) << "it went to its boot loader";
}

TEST_F(UsbOfTheBoard, AHostOnTheSerialLineIsNotPushedAsideByOneOnUsb) {
  instrument::Session session(test::connect(board_), {.host_name = "on the line"});
  test::home_all(session);
  const auto all = rows(4);
  test::Records records;
  instrument::ProgramStream stream(
      {.program_id = 3, .row_count = 4}, [&](std::uint32_t i) { return all[i]; }, records);
  stream.run(session, [](const instrument::ProgramStream& s) { return s.next_index() < 2; });
  const std::string refused = failure_of([&] { instrument::Session second(bulk()); });
  EXPECT_NE(refused.find("in use by host 'on the line'"), std::string::npos) << refused;
  stream.run(session);
  EXPECT_EQ(records.all.size(), 4u);
}

TEST_F(UsbOfTheBoard, PulledAndPluggedInDuringAScanLosesNoRecordAndRepeatsNone) {
  const auto all = rows(30);
  test::Records records;
  instrument::ProgramStream stream(
      {.program_id = 3, .row_count = 30}, [&](std::uint32_t i) { return all[i]; }, records);
  {
    instrument::Session session(bulk());
    test::home_all(session);
    stream.run(session, [](const instrument::ProgramStream& s) { return s.next_index() < 11; });
  }
  ASSERT_LT(records.all.size(), 30u);
  // In the middle of a transfer, too: the host has asked and not fetched the answer.
  cable_.write(protocol::usb::bulk_out, {1, 2, 3, 0});
  board_.run_for(5'000);
  ASSERT_TRUE(cable_.plug_in());
  instrument::Session session(bulk());
  EXPECT_TRUE(stream.run(session));
  ASSERT_EQ(records.all.size(), 30u);
  for (std::uint32_t i = 0; i < 30; ++i) EXPECT_EQ(records.all[i].index, i);
}

TEST_F(UsbOfTheBoard, AHaltedPipeIsSilentUntilTheHaltIsCleared) {
  instrument::Session session(bulk());
  EXPECT_TRUE(cable_.control(0x02, 3, 0, protocol::usb::bulk_in, 0).ok()) << "SET_FEATURE halt";
  EXPECT_EQ(cable_.read(protocol::usb::bulk_in, 64, 10'000).status, usbip::urb_status::stalled);
  EXPECT_TRUE(cable_.control(0x02, 3, 0, protocol::usb::bulk_out, 0).ok());
  EXPECT_EQ(cable_.write(protocol::usb::bulk_out, {0}).status, usbip::urb_status::stalled);
  EXPECT_TRUE(cable_.control(0x02, 1, 0, protocol::usb::bulk_in, 0).ok()) << "CLEAR_FEATURE";
  EXPECT_TRUE(cable_.control(0x02, 1, 0, protocol::usb::bulk_out, 0).ok());
  EXPECT_EQ(session.request(protocol::GetStatus{}).fault, 0);
}

TEST_F(UsbOfTheBoard, TheProtocolRunsInReportsToo) {
  std::array<std::uint8_t, protocol::wire_frame_size<protocol::Hello>> frame;
  const std::size_t size =
      protocol::FrameWriter::write(5,
                                   protocol::Hello{.version = protocol::protocol_version,
                                                   .schema_hash = protocol::schema_hash,
                                                   .host_name = {}},
                                   frame);
  Bytes report(frame.begin(), frame.begin() + static_cast<std::ptrdiff_t>(size));
  report.resize(protocol::usb::report_bytes, 0);
  ASSERT_TRUE(cable_.write(protocol::usb::reports_out, report).ok());
  protocol::FrameReader reader;
  int replies = 0;
  for (int i = 0; i < 4 && replies == 0; ++i) {
    const auto got = cable_.read(protocol::usb::reports_in, protocol::usb::report_bytes, 20'000);
    reader.feed(got.bytes, [&](const protocol::FrameView& f) {
      replies += f.type == protocol::HelloReply::info.id ? 1 : 0;
    });
  }
  EXPECT_EQ(replies, 1);
}

TEST_F(UsbOfTheBoard, TheSerialLineIsForWhoeverComesWhenNobodyIsOnUsb) {
  { instrument::Session over_usb(bulk()); }
  instrument::SessionOptions impatient;
  impatient.answer_timeout = std::chrono::milliseconds(100);
  impatient.attempts = 2;
  EXPECT_THROW(instrument::Session(test::connect(board_), impatient), std::exception);
  board_.run_for(2'000'000);
  instrument::Session serial(test::connect(board_));
  EXPECT_EQ(serial.request(protocol::GetStatus{}).fault, 0);
}

}  // namespace
}  // namespace umov
