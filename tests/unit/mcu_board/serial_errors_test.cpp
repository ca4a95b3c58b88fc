// DMA errors of the serial line on the emulated chip: what was being sent is sent to its end, what
// came in while the receiver was off is asked for again.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "hil/mcu/board/mcu_board.hpp"
#include "protocol/schema.hpp"
#include "tests/unit/mcu_board/noisy_stages.hpp"
#include "tests/unit/mcu_board/scan_run.hpp"

namespace umov {
namespace {

/// Fails one of the streams now and then while bytes are under way.
class FailingBoard {
 public:
  FailingBoard(mcu::McuBoard& board, bool sending, double mean_us)
      : board_(&board), sending_(sending), apart_(1 / mean_us) {}
  void deliver(std::span<const std::uint8_t> bytes) { board_->deliver(bytes); }
  std::size_t take_output(std::vector<std::uint8_t>& buffer) { return board_->take_output(buffer); }
  std::uint64_t now_us() const { return board_->now_us(); }
  bool run_until_output(std::uint64_t max_us) {
    const std::uint64_t limit = board_->now_us() + max_us;
    while (board_->now_us() < limit) {
      const std::uint64_t until = std::min(limit, std::max(next_us_, board_->now_us() + 1));
      if (board_->run_until_output(until - board_->now_us())) break;
      fail_when_due();
    }
    if (sending_ && board_->has_output()) {  // in the middle of what follows the first byte
      board_->run_for(1 + random_() % 200);
      next_us_ = board_->now_us();
      fail_when_due();
    }
    return board_->has_output();
  }
  int failures = 0;

 private:
  void fail_when_due() {
    if (board_->now_us() < next_us_) return;
    failures += board_->chip().fail_serial_dma(sending_) ? 1 : 0;
    next_us_ = board_->now_us() + static_cast<std::uint64_t>(1 + apart_(random_));
  }

  mcu::McuBoard* board_;
  bool sending_;
  std::mt19937 random_{3};
  std::exponential_distribution<double> apart_;
  std::uint64_t next_us_ = 0;
};

std::vector<std::uint8_t> frame_of(std::uint16_t sequence, const auto& message) {
  std::vector<std::uint8_t> frame(
      protocol::wire_frame_size<std::remove_cvref_t<decltype(message)>>);
  frame.resize(protocol::FrameWriter::write(sequence, message, frame));
  return frame;
}

TEST(SerialErrors, WhatIsSentArrivesWholeOverErrorsOfItsDma) {
  test::NoisyBench bench;
  mcu::McuBoard board(bench, {.image = UMOV_STM32F407_ELF});
  board.run_for(100'000);  // its program has started
  protocol::Hello hello{
      .version = protocol::protocol_version, .schema_hash = protocol::schema_hash, .host_name = {}};
  board.deliver(frame_of(1, hello));
  board.run_for(10'000);
  protocol::FrameReader reader;
  std::vector<std::uint8_t> bytes;
  std::mt19937 random(5);
  int replies = 0, failures = 0;
  constexpr int requests = 300;
  for (int i = 0; i < requests; ++i) {
    board.deliver(frame_of(static_cast<std::uint16_t>(2 + i), protocol::GetStatus{}));
    for (int piece = 0; piece < 20; ++piece) {
      board.run_for(random() % 200);
      failures += board.chip().fail_serial_dma(true) ? 1 : 0;
    }
  }
  board.run_for(50'000);
  board.take_output(bytes);
  reader.feed(bytes, [&](const protocol::FrameView& frame) {
    if (frame.type == protocol::Status::info.id) ++replies;
  });
  EXPECT_EQ(replies, requests);
  EXPECT_GT(failures, requests) << "of them, in the middle of replies";
  EXPECT_EQ(reader.counters().bad_crc + reader.counters().garbage + reader.counters().oversize, 0u);
}

TEST(SerialErrors, TheReceiverIsBackWithinTwoMilliseconds) {
  test::NoisyBench bench;
  mcu::McuBoard board(bench, {.image = UMOV_STM32F407_ELF});
  board.run_for(100'000);  // its program has started
  for (int i = 0; i < 100; ++i) {
    EXPECT_TRUE(board.chip().fail_serial_dma(false)) << i;
    board.run_for(2'000);
    board.deliver(frame_of(static_cast<std::uint16_t>(i),
                           protocol::Hello{.version = protocol::protocol_version,
                                           .schema_hash = protocol::schema_hash,
                                           .host_name = {}}));
    EXPECT_TRUE(board.run_until_output(5'000)) << i;
    board.run_for(5'000);
    std::vector<std::uint8_t> bytes;
    board.take_output(bytes);
  }
}

class SerialErrorsOfAScan : public testing::TestWithParam<bool> {};

TEST_P(SerialErrorsOfAScan, LoseAndDoubleNoRecord) {
  test::NoisyBench bench;
  mcu::McuBoard board(bench, {.image = UMOV_STM32F407_ELF});
  FailingBoard failing(board, GetParam(), 20'000);
  std::vector<protocol::ProgramRow> rows;
  for (std::uint32_t i = 0; i < 150; ++i) {
    rows.push_back(
        {.index = i, .target_udeg = {}, .laser = 1, .shutter_open = 1, .gain = 0, .dwell_ms = 2});
  }
  const auto records = test::run_rows(test::connect(failing), rows);
  ASSERT_EQ(records.size(), rows.size());
  for (std::uint32_t i = 0; i < records.size(); ++i) EXPECT_EQ(records[i].index, i);
  EXPECT_GT(failing.failures, 50);
}

INSTANTIATE_TEST_SUITE_P(Streams, SerialErrorsOfAScan, testing::Bool(),
                         [](const auto& which) { return which.param ? "sending" : "receiving"; });

}  // namespace
}  // namespace umov
