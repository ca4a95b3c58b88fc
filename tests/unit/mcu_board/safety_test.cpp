// The flashed image in trouble: whatever happens, it is dark soon, says why once, and knows it
// afterwards.
#include <gtest/gtest.h>

#include <map>

#include "hil/mcu/board/mcu_board.hpp"
#include "host/errors/error.hpp"
#include "protocol/crc32c.hpp"
#include "tests/unit/mcu_board/noisy_stages.hpp"
#include "tests/unit/mcu_board/scan_run.hpp"

namespace umov {
namespace {

using protocol::Fault;
using protocol::State;

constexpr std::uint32_t log_offset = 0x1'0000, log_bytes = 64 * 1024, entry_bytes = 24;
constexpr std::uint32_t vectors_offset = 0x2'0200;  // behind the image's header

class SafetyOfTheBoard : public testing::Test {
 protected:
  void SetUp() override { open_session(); }

  void open_session() {
    session_.reset();
    session_ = std::make_unique<instrument::Session>(test::connect(board_));
  }
  protocol::Status status() { return session_->request(protocol::GetStatus{}); }
  Fault fault() { return static_cast<Fault>(status().fault); }
  State state() { return static_cast<State>(status().state); }
  protocol::LogEntry log_entry(std::uint8_t index) {
    return session_->request(protocol::ReadLog{.index = index});
  }

  /// A row that takes seconds to measure, with light; returns when it is being measured.
  void measure() {
    test::home_all(*session_);
    session_->request(protocol::ProgramBegin{.program_id = 9, .first_row = 0, .row_count = 1});
    session_->send(protocol::ProgramRow{.index = 0,
                                        .target_udeg = {},
                                        .laser = 2,
                                        .shutter_open = 1,
                                        .gain = 0,
                                        .dwell_ms = 20'000});
    const std::uint64_t streams = bench_.stages.streams;
    for (int i = 0; i < 100 && bench_.stages.streams == streams; ++i) listen(20);
    ASSERT_FALSE(bench_.dark());
    ASSERT_GT(bench_.stages.streams, streams);
  }
  void listen(int ms) {
    session_->poll(std::chrono::milliseconds(ms));
    while (auto event = session_->next_event()) {
      if (const auto* told = std::get_if<protocol::FaultEvent>(&*event)) ++told_[told->fault];
    }
  }
  int told(Fault fault) { return told_[static_cast<std::uint8_t>(fault)]; }
  std::vector<std::uint8_t>& flash() { return board_.chip().flash_contents(); }

  test::NoisyBench bench_;
  mcu::McuBoard board_{bench_, {.image = UMOV_STM32F407_ELF}};
  std::unique_ptr<instrument::Session> session_;
  std::map<std::uint8_t, int> told_;
};

TEST_F(SafetyOfTheBoard, AStallGoesDarkWithin500Instructions) {
  measure();
  const double begin_s = mcu::seconds(board_.chip().now());
  board_.signal_stall(2);
  EXPECT_TRUE(bench_.dark());
  EXPECT_LT((bench_.went_dark_s - begin_s) * 168e6, 500);
  listen(50);
  EXPECT_EQ(fault(), Fault::stall);
  EXPECT_EQ(told(Fault::stall), 1);
  EXPECT_EQ(status().homed_mask, 63 & ~(1 << 2)) << "where the axis is, nobody knows";
  EXPECT_EQ(log_entry(0).fault, static_cast<std::uint8_t>(Fault::stall));
  EXPECT_EQ(log_entry(0).detail, 2);
}

TEST_F(SafetyOfTheBoard, ABreakOfTheInterlockShorterThanATickIsLatched) {
  measure();
  bench_.stages.interlock = false;
  board_.look_at_inputs();
  board_.run_for(20);
  bench_.stages.interlock = true;
  board_.look_at_inputs();
  listen(50);
  EXPECT_EQ(fault(), Fault::interlock);
  EXPECT_TRUE(bench_.dark());
}

TEST_F(SafetyOfTheBoard, AStallLineThatIsHighFromTheStartIsAFaultThatCannotBeCleared) {
  board_.set_stall(4, true);
  board_.reset(mcu::ResetSource::power_on);
  board_.run_for(5'000);
  open_session();
  EXPECT_EQ(fault(), Fault::stall);
  EXPECT_EQ(log_entry(0).detail, 4);
  const protocol::ClearFault clear{.fault = static_cast<std::uint8_t>(Fault::stall)};
  EXPECT_THROW(session_->request(clear), Error);
  board_.set_stall(4, false);
  session_->request(clear);
  EXPECT_EQ(fault(), Fault::none);
}

TEST_F(SafetyOfTheBoard, SamplesThatWereOverwrittenBeforeTheyWereReadAreAFault) {
  for (const std::uint64_t late_us : {5'100u, 6'400u, 7'600u, 10'000u}) {
    SCOPED_TRACE(late_us);
    measure();
    board_.run_for(1'000);
    board_.chip().stand_still(late_us * mcu::time_per_us);
    board_.run_for(late_us + 1'000);
    EXPECT_TRUE(bench_.dark());
    EXPECT_EQ(fault(), Fault::adc_overrun);
    session_->request(protocol::ClearFault{.fault = static_cast<std::uint8_t>(Fault::adc_overrun)});
    session_->request(protocol::ProgramControl{.action = 2});
  }
}

TEST_F(SafetyOfTheBoard, AProcessorFaultIsLoggedWithItsPlace) {
  measure();
  const std::uint32_t boot = session_->device().boot_id;
  // SysTick's vector gets the address of the hard fault's: the next tick is a fault.
  const std::uint32_t place = vectors_offset + 4 * 15, hard_fault = vectors_offset + 4 * 3;
  const std::vector<std::uint8_t> vector(flash().begin() + place, flash().begin() + place + 4);
  std::copy_n(flash().begin() + hard_fault, 4, flash().begin() + place);
  for (int i = 0; i < 2'000 && board_.chip().software_resets() == 0; ++i) board_.run_for(1);
  ASSERT_EQ(board_.chip().software_resets(), 1u);
  EXPECT_TRUE(bench_.dark());
  std::copy(vector.begin(), vector.end(), flash().begin() + place);
  board_.run_for(5'000);
  open_session();
  EXPECT_EQ(fault(), Fault::internal);
  EXPECT_EQ(session_->device().boot_id, boot + 1);
  const auto entry = log_entry(0);
  EXPECT_EQ(entry.fault, static_cast<std::uint8_t>(Fault::internal));
  EXPECT_GE(entry.detail, 0x0802'0000) << "an address in the image";
  EXPECT_LT(entry.detail, 0x0803'8000);
  // A reset that nobody noted is none.
  board_.reset(mcu::ResetSource::software);
  board_.run_for(5'000);
  open_session();
  EXPECT_EQ(fault(), Fault::none);
}

TEST_F(SafetyOfTheBoard, AnOpenInterlockIsNoticedWithinTwoMilliseconds) {
  measure();
  bench_.stages.interlock = false;
  const mcu::Time begin = board_.chip().now();
  board_.run_for(2'000);
  EXPECT_TRUE(bench_.dark());
  EXPECT_LT(bench_.went_dark_s - mcu::seconds(begin), 2e-3);
  listen(50);
  EXPECT_EQ(fault(), Fault::interlock);
  EXPECT_EQ(told(Fault::interlock), 1);
  EXPECT_THROW(session_->request(protocol::ClearFault{.fault = 1}), Error) << "still open";
  bench_.stages.interlock = true;
  board_.run_for(3'000);
  session_->request(protocol::ClearFault{.fault = 1});
  EXPECT_EQ(fault(), Fault::none);
  EXPECT_TRUE(bench_.dark()) << "clearing switches nothing on";
}

TEST_F(SafetyOfTheBoard, AProgramThatHangsIsResetAndComesBackDarkWithItsHistory) {
  measure();
  const std::uint32_t boot = session_->device().boot_id;
  // SysTick's vector points to an instruction that jumps to itself: `b .`.
  const std::uint32_t place = vectors_offset + 4 * 15;
  const std::array<std::uint8_t, 4> vector = {flash()[place], flash()[place + 1],
                                              flash()[place + 2], flash()[place + 3]};
  const std::uint32_t loop = 0x2'0000 + 0x1'8000;
  flash()[loop] = 0xFE;
  flash()[loop + 1] = 0xE7;
  const std::uint32_t target = 0x0800'0000 + loop + 1;
  for (unsigned i = 0; i < 4; ++i) flash()[place + i] = static_cast<std::uint8_t>(target >> 8 * i);
  board_.run_for(300'000);
  EXPECT_GE(board_.chip().watchdog_resets(), 1u);
  EXPECT_TRUE(bench_.dark());
  for (unsigned i = 0; i < 4; ++i) flash()[place + i] = vector[i];
  board_.reset(mcu::ResetSource::watchdog);
  board_.run_for(5'000);
  open_session();
  EXPECT_EQ(fault(), Fault::watchdog);
  EXPECT_GT(session_->device().boot_id, boot);
  EXPECT_EQ(status().homed_mask, 0);
  EXPECT_THROW(session_->request(protocol::Home{.axis_mask = 63}), Error) << "until it is cleared";
  EXPECT_EQ(log_entry(0).fault, static_cast<std::uint8_t>(Fault::watchdog));
  EXPECT_EQ(log_entry(0).boot_id, session_->device().boot_id);
}

TEST_F(SafetyOfTheBoard, ABrownOutIsToldFromAPowerOn) {
  measure();
  const std::uint32_t boot = session_->device().boot_id;
  board_.reset(mcu::ResetSource::brown_out);
  EXPECT_TRUE(bench_.dark()) << "pins without a program are inputs";
  board_.run_for(5'000);
  open_session();
  EXPECT_EQ(fault(), Fault::brown_out);
  EXPECT_EQ(session_->device().boot_id, boot + 1);

  board_.reset(mcu::ResetSource::power_on);
  board_.run_for(5'000);
  open_session();
  EXPECT_EQ(fault(), Fault::none);
  EXPECT_EQ(session_->device().boot_id, boot + 2);
  EXPECT_EQ(log_entry(0).fault, static_cast<std::uint8_t>(Fault::brown_out)) << "still in the log";
}

TEST_F(SafetyOfTheBoard, ABoardThatFeedsTheChipThroughADiodeIsNotBrownedOut) {
  // 2.95 V: what is left of 3.3 V behind a Schottky diode.
  board_.chip().set_supply(2950);
  measure();
  EXPECT_EQ(fault(), Fault::none);
  board_.chip().set_supply(2800);
  board_.run_for(5'000);
  EXPECT_EQ(fault(), Fault::brown_out);
  EXPECT_TRUE(bench_.dark());
}

TEST_F(SafetyOfTheBoard, AHostThatFallsSilentLeavesItDark) {
  measure();
  board_.run_for(2'900'000);
  EXPECT_FALSE(bench_.dark());
  board_.run_for(200'000);
  EXPECT_TRUE(bench_.dark());
  EXPECT_EQ(fault(), Fault::link_lost);
}

TEST_F(SafetyOfTheBoard, AnEmergencyStopBrakesAllAxesAndTheirPositionsAreKnown) {
  test::home_all(*session_);
  session_->request(protocol::Move{.axis = 1, .target_udeg = 80'000'000});
  listen(300);
  EXPECT_EQ(state(), State::moving);
  session_->request(protocol::Stop{.emergency = 1});
  for (int i = 0; i < 100; ++i) listen(10);
  EXPECT_EQ(fault(), Fault::emergency_stop);
  const std::int32_t steps = bench_.stages.position[1];
  EXPECT_GT(steps, 1'000);
  EXPECT_LT(steps, 60'000);
  EXPECT_EQ(status().position_udeg[1], steps * 1'000) << "360,000 steps a turn";
}

TEST_F(SafetyOfTheBoard, ATornLogEntryIsPassedOver) {
  board_.signal_stall(3);
  board_.run_for(5'000);
  session_->request(protocol::Stop{.emergency = 1});
  board_.run_for(5'000);
  ASSERT_EQ(log_entry(0).fault, static_cast<std::uint8_t>(Fault::emergency_stop));
  // Start, stall, emergency stop: the power failed while the third was written.
  const std::uint32_t torn = log_offset + 2 * entry_bytes;
  for (std::uint32_t i = 8; i < entry_bytes; ++i) flash()[torn + i] = 0xFF;
  board_.reset(mcu::ResetSource::power_on);
  board_.run_for(5'000);
  open_session();
  EXPECT_EQ(log_entry(0).fault, static_cast<std::uint8_t>(Fault::stall));
  EXPECT_EQ(log_entry(0).count, 1);
  EXPECT_EQ(session_->device().boot_id, 2u);
}

TEST_F(SafetyOfTheBoard, AFullLogIsEmptiedAtAStartAndKeepsTheNewest) {
  // The sector filled with faults of start 7, told apart by their detail.
  std::uint32_t count = 0;
  for (std::uint32_t at = 0; at + entry_bytes <= log_bytes; at += entry_bytes, ++count) {
    const std::array<std::uint32_t, 5> words = {
        0x4641'0000 | static_cast<std::uint32_t>(Fault::stall), 7, 1000 + count, 0, count};
    std::array<std::uint8_t, 20> bytes;
    for (std::size_t i = 0; i < bytes.size(); ++i)
      bytes[i] = static_cast<std::uint8_t>(words[i / 4] >> 8 * (i % 4));
    const std::uint32_t crc = protocol::crc32c(bytes);
    for (std::uint32_t i = 0; i < entry_bytes; ++i) {
      flash()[log_offset + at + i] =
          i < 20 ? bytes[i] : static_cast<std::uint8_t>(crc >> 8 * (i - 20));
    }
  }
  const auto full = flash();
  board_.reset(mcu::ResetSource::power_on);
  for (int i = 0; i < 100'000 && flash()[log_offset + 4] != 0xFF; ++i) board_.run_for(1);
  ASSERT_EQ(flash()[log_offset + 4], 0xFF) << "erased";
  board_.reset(mcu::ResetSource::power_on);
  board_.run_for(50'000);
  open_session();
  EXPECT_EQ(session_->device().boot_id, 9u) << "the power failed between erasing and writing";

  flash() = full;
  board_.reset(mcu::ResetSource::power_on);
  board_.run_for(700'000);
  open_session();
  EXPECT_EQ(board_.chip().watchdog_resets(), 0u) << "erasing takes half a second";
  EXPECT_EQ(log_entry(0).detail, static_cast<std::int32_t>(count - 1));
  EXPECT_EQ(log_entry(63).detail, static_cast<std::int32_t>(count - 64));
  EXPECT_EQ(log_entry(0).count, 64);
  board_.reset(mcu::ResetSource::power_on);
  board_.run_for(10'000);
  open_session();
  EXPECT_EQ(log_entry(63).detail, static_cast<std::int32_t>(count - 64)) << "from the flash again";
}

}  // namespace
}  // namespace umov
