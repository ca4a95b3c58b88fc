// Settings saved by the flashed image in the emulated chip's flash: over restarts, with the power
// cut while they are written, and damaged.
#include <gtest/gtest.h>

#include "hil/mcu/board/mcu_board.hpp"
#include "host/instrument/refusals.hpp"
#include "tests/unit/mcu_board/noisy_stages.hpp"
#include "tests/unit/mcu_board/scan_run.hpp"
#include "tests/unit/mcu_board/trouble_rigs.hpp"

namespace umov {
namespace {

constexpr std::uint32_t settings_offset = 0x8000, settings_bytes = 32 * 1024;

class SettingsOfTheBoard : public testing::Test {
 protected:
  void SetUp() override { open_session(); }
  void open_session() {
    session_.reset();
    session_ = std::make_unique<instrument::Session>(test::connect(board_));
  }
  void restart() {
    board_.reset(mcu::ResetSource::power_on);
    board_.run_for(50'000);
    open_session();
  }
  void set_speed(std::uint32_t mdeg_s) {
    const auto now = session_->request(protocol::GetAxis{1});
    session_->request(protocol::SetAxis{1, now.min_udeg, now.max_udeg, mdeg_s,
                                        now.acceleration_mdeg_s2, now.jerk_mdeg_s3,
                                        now.take_up_udeg});
  }
  std::uint32_t speed() { return session_->request(protocol::GetAxis{1}).speed_mdeg_s; }
  std::uint8_t fault() { return session_->request(protocol::GetStatus{}).fault; }
  std::vector<std::uint8_t> stored() {
    const auto begin = board_.chip().flash_contents().begin() + settings_offset;
    return {begin, begin + settings_bytes};
  }

  test::NoisyBench bench_;
  mcu::McuBoard board_{bench_, {.image = UMOV_STM32F407_ELF}};
  std::unique_ptr<instrument::Session> session_;
};

TEST_F(SettingsOfTheBoard, SavedOnesAreInForceAfterAPowerCycleAndOthersAreNot) {
  set_speed(11'000);
  restart();
  EXPECT_EQ(speed(), 40'000u);
  set_speed(12'000);
  session_->request(protocol::SaveSettings{0});
  restart();
  EXPECT_EQ(speed(), 12'000u);
  EXPECT_EQ(fault(), 0);
  session_->request(protocol::SaveSettings{1});
  restart();
  EXPECT_EQ(speed(), 40'000u);
}

TEST_F(SettingsOfTheBoard, APowerCutWhileTheyAreWrittenLeavesTheOldOrTheNew) {
  std::uint32_t saved = 12'000;
  set_speed(saved);
  session_->request(protocol::SaveSettings{0});
  int olds = 0, news = 0;
  for (int words = 0; words <= 72; words += 6) {
    const std::uint32_t wanted = 20'000 + static_cast<std::uint32_t>(words);
    set_speed(wanted);
    const auto before = stored();
    std::array<std::uint8_t, protocol::wire_frame_size<protocol::SaveSettings>> frame;
    const std::size_t size = protocol::FrameWriter::write(999, protocol::SaveSettings{0}, frame);
    board_.deliver(std::span(frame).first(size));
    for (int i = 0; i < 3'000 && stored() == before; ++i) board_.run_for(1);
    ASSERT_NE(stored(), before) << "it writes";
    board_.run_for(16 * static_cast<unsigned>(words));  // 16 us a word
    restart();
    EXPECT_EQ(fault(), 0);
    (speed() == saved ? olds : news) += 1;
    ASSERT_TRUE(speed() == saved || speed() == wanted) << speed() << " after " << words << " words";
    saved = speed();
  }
  EXPECT_GE(olds, 8);
  EXPECT_GE(news, 1);
}

TEST_F(SettingsOfTheBoard, DamagedOnesAreOneNamedFaultInTheLogAndTheBuiltInOnesHold) {
  set_speed(12'000);
  session_->request(protocol::SaveSettings{0});
  board_.chip().flash_contents()[settings_offset + 20] ^= 4;
  restart();
  const auto corrupt = static_cast<std::uint8_t>(protocol::Fault::settings_corrupt);
  EXPECT_EQ(fault(), corrupt);
  EXPECT_EQ(speed(), 40'000u);
  EXPECT_EQ(session_->request(protocol::ReadLog{0}).fault, corrupt);
  EXPECT_THROW(session_->request(protocol::Home{1}), instrument::Refused) << "not before a clear";
  session_->request(protocol::ClearFault{corrupt});
  set_speed(13'000);
  session_->request(protocol::SaveSettings{0});
  restart();
  EXPECT_EQ(fault(), 0);
  EXPECT_EQ(speed(), 13'000u);
}

TEST_F(SettingsOfTheBoard, HundredsOfSavingsWithoutARestartAreNoTroubleToDeadlinesAndWatchdog) {
  std::uint32_t speed_mdeg_s = 1'000;
  std::uint64_t longest_us = 0;
  for (int i = 0; i < 300; ++i) {
    set_speed(++speed_mdeg_s);
    const std::uint64_t begin_us = board_.now_us();
    session_->request(protocol::SaveSettings{0});
    longest_us = std::max(longest_us, board_.now_us() - begin_us);
    ASSERT_EQ(fault(), 0) << "after " << i << " savings";
  }
  EXPECT_GT(longest_us, 250'000u) << "a page was erased meanwhile";
  EXPECT_EQ(board_.chip().watchdog_resets(), 0u);
  restart();
  EXPECT_EQ(speed(), speed_mdeg_s);
  board_.chip().stand_still(300'000 * mcu::time_per_us);
  board_.run_for(400'000);
  EXPECT_EQ(board_.chip().watchdog_resets(), 1u) << "it is as strict as before";
}

/// What a power cut leaves is what the flash holds at that moment: it is looked at after each word
/// that the saving writes, and a start is made with it. Of the erasure the emulation knows no
/// middle; two are made up.
TEST_F(SettingsOfTheBoard, APowerCutWhileASavingErasesAPageLeavesTheOldOrTheNew) {
  std::uint32_t saved = 1'000;
  for (int i = 0; i < 64 + 63; ++i) {
    set_speed(++saved);
    session_->request(protocol::SaveSettings{0});
  }
  const std::uint32_t wanted = saved + 1;
  set_speed(wanted);
  std::vector<std::vector<std::uint8_t>> moments{stored()};
  board_.deliver(test::save_settings_frame());
  for (int i = 0; i < 20'000; ++i) {
    board_.run_for(16);  // a word
    if (auto now = stored(); now != moments.back()) moments.push_back(std::move(now));
  }
  ASSERT_GT(moments.size(), 30u);
  constexpr std::size_t page_bytes = settings_bytes / 2;
  const auto page_erased = std::count(moments[1].begin(), moments[1].begin() + page_bytes, 0xFF);
  ASSERT_GT(page_erased, static_cast<std::ptrdiff_t>(page_bytes) - 300) << "the older page first";
  for (const std::size_t from : {std::size_t{0}, page_bytes / 2 + 100}) {
    auto half = moments[0];
    std::fill_n(half.begin() + static_cast<std::ptrdiff_t>(from), page_bytes / 3, 0xFF);
    moments.push_back(half);
  }
  int olds = 0, news = 0;
  for (std::size_t i = 0; i < moments.size(); ++i) {
    std::copy(moments[i].begin(), moments[i].end(),
              board_.chip().flash_contents().begin() + settings_offset);
    restart();
    EXPECT_EQ(fault(), 0) << i;
    ASSERT_TRUE(speed() == saved || speed() == wanted) << speed() << " at " << i;
    (speed() == saved ? olds : news) += 1;
  }
  EXPECT_GE(olds, 30);
  EXPECT_GE(news, 1);
}

}  // namespace
}  // namespace umov
