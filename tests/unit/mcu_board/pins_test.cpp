// BOOT0, NRST and the interlock of the emulated board, driven as a GPIO adapter drives them.
#include <gtest/gtest.h>

#include "host/cli/emulator/bench_lines.hpp"
#include "host/cli/emulator/mcu/mcu_instrument.hpp"
#include "host/cli/emulator/mcu/mcu_pins.hpp"
#include "host/instrument/session.hpp"

namespace umov {
namespace {

class LinesOfTheBoard : public testing::Test {
 protected:
  std::uint32_t boot_id() {
    return instrument::Session(emulator::connect_serial(instrument_)).device().boot_id;
  }
  protocol::Status status() {
    return instrument::Session(emulator::connect_serial(instrument_))
        .request(protocol::GetStatus{});
  }

  std::shared_ptr<emulator::McuInstrument> instrument_ = std::make_shared<emulator::McuInstrument>(
      emulator::BenchOptions{.sample = "red-gloss", .plant_file = {}, .settings = {}},
      mcu::McuBoardOptions{.image = UMOV_STM32F407_ELF});
  emulator::McuPins pins_{instrument_->board().chip()};
  emulator::BenchLines lines_{instrument_->plant(), pins_};
};

TEST_F(LinesOfTheBoard, TheInterlockLineOpensIt) {
  ASSERT_EQ(status().fault, 0);
  lines_.drive(emulator::BenchLines::interlock, false);
  instrument_->board().run_for(3'000);
  EXPECT_EQ(static_cast<protocol::Fault>(status().fault), protocol::Fault::interlock);
  lines_.drive(emulator::BenchLines::interlock, std::nullopt);
  instrument_->board().run_for(3'000);
  EXPECT_EQ(status().interlock_closed, 1) << "closed again, latched still";
  EXPECT_EQ(static_cast<protocol::Fault>(status().fault), protocol::Fault::interlock);
}

TEST_F(LinesOfTheBoard, NrstHoldsTheProgramAndStartsItAnew) {
  const std::uint32_t first = boot_id();
  lines_.drive(emulator::BenchLines::nrst, false);
  instrument_->board().run_for(10'000);
  EXPECT_FALSE(instrument_->board().chip().runs_program());
  EXPECT_EQ(instrument_->board().chip().instructions(), 0u);
  lines_.drive(emulator::BenchLines::nrst, std::nullopt);
  instrument_->board().run_for(50'000);
  EXPECT_EQ(boot_id(), first + 1);
}

TEST_F(LinesOfTheBoard, Boot0AtAResetKeepsTheProgramFromStarting) {
  const std::uint32_t first = boot_id();
  lines_.drive(emulator::BenchLines::boot0, true);
  instrument_->board().run_for(1'000);
  EXPECT_TRUE(instrument_->board().chip().runs_program()) << "looked at in a reset only";
  lines_.drive(emulator::BenchLines::nrst, false);
  lines_.drive(emulator::BenchLines::nrst, true);
  instrument_->board().run_for(50'000);
  EXPECT_FALSE(instrument_->board().chip().runs_program());
  lines_.drive(emulator::BenchLines::boot0, std::nullopt);
  lines_.drive(emulator::BenchLines::nrst, false);
  lines_.drive(emulator::BenchLines::nrst, true);
  instrument_->board().run_for(50'000);
  EXPECT_EQ(boot_id(), first + 1) << "the ROM loader counts no starts";
}

}  // namespace
}  // namespace umov
