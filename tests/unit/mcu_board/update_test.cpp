// The boot loader that is flashed, on the emulated chip: it starts the program, takes another one
// over USB by DFU, and leaves something that starts wherever the power is cut.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/mcu_board/update_rig.hpp"

namespace umov {
namespace {

using instrument::UpdateRefused;
using test::Bytes;
namespace dfu = protocol::dfu;

using test::previous;
using test::running;
using test::staged;

class UpdateOfTheBoard : public test::BoardWithBootLoader {};

TEST_F(UpdateOfTheBoard, TheBootLoaderChecksTheSignatureAndStartsTheProgramInATenthOfASecond) {
  mcu::McuBoard alone(bench_, {.image = UMOV_STM32F407_ELF});
  for (mcu::McuBoard* board : {&board_, &alone}) {
    while (!board->usb_connected()) board->run_for(500);
  }
  const double longer_ms = 1e-3 * static_cast<double>(board_.now_us() - alone.now_us());
  std::printf("through the boot loader a start takes %.0f ms longer\n", longer_ms);
  EXPECT_LT(longer_ms, 100);
  EXPECT_EQ(plug_in(board_), protocol::usb::product_id);
  instrument::Session session(test::connect(board_));
  EXPECT_EQ(session.request(protocol::GetStatus{}).fault, 0);
  const auto image = instrument::read_firmware_image(image_file());
  EXPECT_EQ(session.device().firmware_hash, image.header.source_hash);
  EXPECT_TRUE(instrument::signed_by(image, instrument::public_key(test::development_key())));
  EXPECT_TRUE(holds(running, image.bytes)) << "the ELF file is signed like the .bin file";
  auto again = image;
  instrument::sign_image(again, test::development_key());
  EXPECT_EQ(again.bytes, image.bytes) << "libsodium and the build sign alike";
  const auto suffixed = instrument::read_firmware_image(
      std::filesystem::path(image_file()).replace_extension(".dfu"));
  EXPECT_EQ(suffixed.bytes, image.bytes);
}

TEST_F(UpdateOfTheBoard, AnUpdateFromTheRunningProgramAndBackToIt) {
  const auto old = instrument::read_firmware_image(image_file());
  const auto newer = image_of(old.header.version + 5);
  detach();
  EXPECT_EQ(instrument::dfu_upload(dfu_), old.bytes);
  EXPECT_THAT(dfu_.text(2), testing::HasSubstr("development key"));
  const std::uint64_t begin_us = board_.now_us();
  instrument::dfu_download(dfu_, newer.bytes);
  std::printf("an update takes %.1f s of the controller's time\n",
              1e-6 * static_cast<double>(board_.now_us() - begin_us));
  instrument::dfu_leave(dfu_);
  board_.run_for(5'000);
  EXPECT_EQ(plug_in(board_), protocol::usb::product_id);
  EXPECT_TRUE(holds(running, newer.bytes));
  EXPECT_TRUE(holds(previous, old.bytes));
  instrument::Session session(test::connect(board_));
  EXPECT_EQ(session.request(protocol::GetStatus{}).fault, 0) << "no fault by the resets";
}

TEST_F(UpdateOfTheBoard, WhatIsRefusedLeavesTheProgramAsItWas) {
  const auto old = instrument::read_firmware_image(image_file());
  detach();
  auto foreign = image_of(old.header.version + 1);
  instrument::sign_image(foreign, {1, 2, 3});
  auto older = image_of(old.header.version - 1);
  auto other_board = image_of(old.header.version + 1);
  other_board.header.board[0] = 'X';
  instrument::sign_image(other_board, test::development_key());
  for (const auto& [image, says] :
       {std::pair{foreign, "not signed"}, {older, "older"}, {other_board, "another board"}}) {
    try {
      instrument::dfu_download(dfu_, image.bytes);
      ADD_FAILURE() << says;
    } catch (const UpdateRefused& refused) {
      EXPECT_THAT(refused.what(), testing::HasSubstr(says));
    }
  }
  EXPECT_TRUE(holds(running, old.bytes));
  ASSERT_TRUE(cable_.control(0x01, 11, dfu::setting_older_too, 0, 0).ok());
  instrument::dfu_download(dfu_, older.bytes);
  EXPECT_TRUE(holds(running, older.bytes)) << "forced";
}

TEST_F(UpdateOfTheBoard, TheProgramIsNotLeftWhileItMovesOrMeasures) {
  ASSERT_EQ(plug_in(board_), protocol::usb::product_id);
  instrument::Session session(test::connect(board_));
  session.request(protocol::Home{1});
  EXPECT_EQ(cable_.control(0x21, dfu::detach, 1000, 3, 0).status, usbip::urb_status::stalled);
  while (session.request(protocol::GetStatus{}).state != 0) board_.run_for(20'000);
  test::home_all(session);
  session.request(protocol::ProgramBegin{.program_id = 9, .first_row = 0, .row_count = 1});
  EXPECT_EQ(cable_.control(0x21, dfu::detach, 1000, 3, 0).status, usbip::urb_status::stalled);
  session.request(protocol::ProgramControl{2});
  EXPECT_TRUE(cable_.control(0x21, dfu::detach, 1000, 3, 0).ok());
}

TEST_F(UpdateOfTheBoard, ABoardWithoutAProgramWaitsForOne) {
  mcu::McuBoard bare(bench_, {.image = {}, .boot_loader = UMOV_STM32F407_BOOT_ELF});
  test::UsbCable cable(bare);
  test::DfuOfTheBoard pipe(bare, cable, 0);
  for (int i = 0; i < 100 && !bare.usb_connected(); ++i) bare.run_for(10'000);
  ASSERT_TRUE(cable.plug_in());
  EXPECT_TRUE(instrument::dfu_upload(pipe).empty());
  instrument::dfu_download(pipe, instrument::read_firmware_image(image_file()).bytes);
  instrument::dfu_leave(pipe);
  bare.run_for(300'000);
  instrument::Session session(test::connect(bare));
  EXPECT_EQ(session.request(protocol::GetStatus{}).fault, 0);
}

TEST_F(UpdateOfTheBoard, WithoutABootLoaderTheProgramStaysWhereItIs) {
  mcu::McuBoard alone(bench_, {.image = UMOV_STM32F407_ELF});
  test::UsbCable cable(alone);
  alone.run_for(50'000);
  ASSERT_TRUE(cable.plug_in());
  EXPECT_EQ(cable.control(0x21, dfu::detach, 1000, 3, 0).status, usbip::urb_status::stalled);
}

/// Cut at moments all over an update; every byte of it is cut in tests/unit/boot, by the same code.
TEST_F(UpdateOfTheBoard, APowerCutDuringAnUpdateLeavesAProgramThatStarts) {
  const auto old = instrument::read_firmware_image(image_file());
  const auto newer = image_of(old.header.version + 5);
  struct Cut {};
  int olds = 0, news = 0;
  for (const std::uint64_t after_ms : {500, 2'000, 2'700, 3'400, 3'600}) {
    board_.reset(mcu::ResetSource::power_on);
    put(running, old.bytes);
    put(staged, Bytes(2 * 128 * 1024, 0xFF));
    detach();
    const std::uint64_t limit_us = board_.now_us() + 1000 * after_ms;
    /// A cable on which time ends.
    class Ending final : public instrument::DfuPipe {
     public:
      Ending(test::DfuOfTheBoard& pipe, mcu::McuBoard& board, std::uint64_t limit)
          : pipe_(&pipe), board_(&board), limit_us_(limit) {}
      Answer read(std::uint8_t r, std::uint16_t v, std::size_t n) override {
        return pipe_->read(r, v, n);
      }
      bool write(std::uint8_t r, std::uint16_t v, std::span<const std::uint8_t> b) override {
        return pipe_->write(r, v, b);
      }
      void wait(std::chrono::milliseconds duration) override {
        for (int i = 0; i < duration.count(); ++i) {
          board_->run_for(1'000);
          if (board_->now_us() > limit_us_) throw Cut{};
        }
      }
      std::string text(std::uint8_t index) override { return pipe_->text(index); }
      std::string name() const override { return pipe_->name(); }

     private:
      test::DfuOfTheBoard* pipe_;
      mcu::McuBoard* board_;
      std::uint64_t limit_us_;
    } ending(dfu_, board_, limit_us);
    EXPECT_THROW(instrument::dfu_download(ending, newer.bytes), Cut) << after_ms;
    board_.reset(mcu::ResetSource::power_on);
    EXPECT_EQ(plug_in(board_), protocol::usb::product_id) << after_ms;
    ASSERT_TRUE(holds(running, old.bytes) || holds(running, newer.bytes));
    (holds(running, newer.bytes) ? news : olds) += 1;
  }
  EXPECT_GE(olds, 2);
  EXPECT_GE(news, 2);
}

}  // namespace
}  // namespace umov
