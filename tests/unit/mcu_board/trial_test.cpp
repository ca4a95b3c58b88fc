// Images that hang, crash or prove themselves, behind the boot loader that is flashed, on the
// emulated chip.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "firmware/boot/notes.hpp"
#include "firmware/boot/trial.hpp"
#include "host/instrument/refusals.hpp"
#include "tests/unit/mcu_board/update_rig.hpp"

namespace umov {
namespace {

using firmware::boot::Place;
using protocol::Fault;
using test::Bytes;
using test::previous;
using test::running;
using test::staged;
using testing::HasSubstr;

/// The boot loader's places as they lie in the chip, for a look and for setting a scene.
class PlacesOfTheChip final : public firmware::boot::Flash {
 public:
  explicit PlacesOfTheChip(mcu::Stm32f407& chip) : chip_(&chip) {}
  std::span<const std::uint8_t> contents(Place place) const override { return at(place); }
  bool erase(Place place) override {
    std::ranges::fill(at(place), std::uint8_t{0xFF});
    return true;
  }
  bool program(Place place, std::uint32_t offset, std::span<const std::uint8_t> bytes) override {
    for (const std::uint8_t byte : bytes) {
      auto& cell = at(place)[offset++];
      cell = static_cast<std::uint8_t>(cell & byte);
    }
    return true;
  }

 private:
  std::span<std::uint8_t> at(Place place) const {
    constexpr std::array<std::uint32_t, 3> offsets = {running, staged, previous};
    return std::span(chip_->flash_contents())
        .subspan(offsets[static_cast<std::size_t>(place)], test::place_bytes);
  }
  mcu::Stm32f407* chip_;
};

class TrialOnTheBoard : public test::BoardWithBootLoader {
 protected:
  /// The image of the build as another version, whose first instructions are others: properly
  /// signed, whatever they do.
  static Bytes beginning_with(std::span<const std::uint16_t> instructions, std::uint32_t version) {
    auto image = image_of(version);
    const auto* vectors = image.bytes.data() + protocol::ImageHeader::bytes;
    const std::uint32_t entry = vectors[4] | vectors[5] << 8 | vectors[6] << 16 |
                                static_cast<std::uint32_t>(vectors[7]) << 24;
    std::size_t at = (entry & ~1u) - 0x0802'0000;
    for (const std::uint16_t instruction : instructions) {
      image.bytes.at(at++) = static_cast<std::uint8_t>(instruction);
      image.bytes.at(at++) = static_cast<std::uint8_t>(instruction >> 8);
    }
    image.header.program_crc = protocol::crc32c(
        std::span<const std::uint8_t>(image.bytes).subspan(protocol::ImageHeader::bytes));
    instrument::sign_image(image, test::development_key());
    return image.bytes;
  }
  /// Waits for an interrupt that nobody has switched on, and again: hangs before anything else.
  static Bytes hanging(std::uint32_t version) {
    return beginning_with(std::array<std::uint16_t, 2>{0xBF30, 0xE7FD}, version);  // wfi; b .-2
  }
  /// Resets the chip as a handler of processor faults does.
  static Bytes crashing(std::uint32_t version) {
    // MOVW or MOVT of 16 bits to a register (ARMv7-M, A7.7.76, encodings T3 and T1).
    const auto load = [](bool upper, unsigned to, std::uint16_t value) {
      const unsigned first = (upper ? 0xF2C0u : 0xF240u) | value >> 12 | (value >> 11 & 1u) << 10;
      return std::array{
          static_cast<std::uint16_t>(first),
          static_cast<std::uint16_t>((value >> 8 & 7u) << 12 | to << 8 | (value & 0xFFu))};
    };
    std::vector<std::uint16_t> program;
    for (const auto& pair : {load(false, 0, 0xED0C), load(true, 0, 0xE000),  // AIRCR
                             load(false, 1, 0x0004), load(true, 1, 0x05FA)}) {
      program.insert(program.end(), pair.begin(), pair.end());
    }
    program.insert(program.end(), {0x6001, 0xE7FE});  // str r1, [r0]; b .
    return beginning_with(program, version);
  }
  /// As the installer leaves them: on trial, with the image of the build kept.
  void install(const Bytes& image) {
    for (const Place place : {Place::running, Place::staged, Place::previous}) places_.erase(place);
    put(running, image);
    put(staged, image);
    put(previous, old_.bytes);
    ASSERT_TRUE(trial_.begin());
    board_.reset(mcu::ResetSource::power_on);
  }
  void press_reset_button() {
    board_.chip().set_nrst(false);
    board_.run_for(1'000);
    board_.chip().set_nrst(true);
  }
  /// Lets time pass until something shows itself on USB; seconds that went by, 60 if nothing did.
  double wait_for_usb() {
    const std::uint64_t begin_us = board_.now_us();
    for (int i = 0; i < 6'000 && !board_.usb_connected(); ++i) board_.run_for(10'000);
    return 1e-6 * static_cast<double>(board_.now_us() - begin_us);
  }
  /// Lets time pass until that image is no more where programs run.
  bool wait_until_gone(const Bytes& image) {
    for (int i = 0; i < 100'000 && holds(running, image); ++i) board_.run_for(100);
    return !holds(running, image);
  }
  protocol::LogEntry newest_log(instrument::Session& session) {
    return session.request(protocol::ReadLog{0});
  }
  void expect_rolled_back(const std::string& why) {
    EXPECT_TRUE(holds(running, old_.bytes));
    instrument::Session session(test::connect(board_));
    constexpr auto rolled_back = static_cast<std::uint8_t>(Fault::rolled_back);
    EXPECT_EQ(session.request(protocol::GetStatus{}).fault, rolled_back)
        << "the only fault, also after resets by the watchdog";
    const auto entry = newest_log(session);
    EXPECT_EQ(entry.fault, rolled_back);
    EXPECT_EQ(entry.boot_id, session.device().boot_id);
    EXPECT_THAT(instrument::fault_detail(entry.fault, entry.detail), HasSubstr(why));
    EXPECT_THROW(session.request(protocol::Home{1}), instrument::Refused) << "not before a clear";
    session.request(protocol::ClearFault{rolled_back});
    EXPECT_EQ(session.request(protocol::GetStatus{}).fault, 0);
  }

  const instrument::FirmwareImage old_ = instrument::read_firmware_image(image_file());
  const std::uint32_t next_version_ = old_.header.version + 5;
  PlacesOfTheChip places_{board_.chip()};
  firmware::boot::Trial trial_{places_};
};

TEST_F(TrialOnTheBoard, ASignedImageThatHangsBeforeUsbGivesWayToTheOneBeforeItAndTheHostIsTold) {
  const Bytes bad = hanging(next_version_);
  detach();
  EXPECT_EQ(instrument::dfu_download(dfu_, bad), "");
  instrument::dfu_leave(dfu_);
  while (board_.usb_connected()) board_.run_for(1'000);
  const double seconds = wait_for_usb();
  std::printf("an image that hangs is given up after %.1f s\n", seconds);
  EXPECT_LT(seconds, 20);
  EXPECT_EQ(board_.chip().watchdog_resets(), firmware::boot::Trial::most_failures);
  expect_rolled_back("image " + instrument::version_text(next_version_) +
                     " failed its trial: the watchdog");
  board_.reset(mcu::ResetSource::power_on);
  board_.run_for(300'000);
  instrument::Session session(test::connect(board_));
  EXPECT_EQ(session.request(protocol::GetStatus{}).fault, 0) << "told once";
  EXPECT_EQ(newest_log(session).fault, static_cast<std::uint8_t>(Fault::rolled_back))
      << "and kept in the log";
  EXPECT_FALSE(trial_.open()) << "the image before is not on trial";
}

TEST_F(TrialOnTheBoard, OneThatCrashesGivesWayWithinASecondOfErasing) {
  install(crashing(next_version_));
  EXPECT_LT(wait_for_usb(), 4);
  expect_rolled_back("it crashed");
}

TEST_F(TrialOnTheBoard, OneThatNoHostReachesGivesWayToThreePressesOfTheResetButton) {
  install(image_of(next_version_).bytes);
  for (int press = 0; press < 3; ++press) {
    EXPECT_LT(wait_for_usb(), 1);
    EXPECT_FALSE(holds(running, old_.bytes)) << press;
    press_reset_button();
  }
  wait_for_usb();
  expect_rolled_back("reset by hand");
}

TEST_F(TrialOnTheBoard, PressesOfTheResetButtonInTheBootLoaderSayNothingOfTheImage) {
  install(image_of(next_version_).bytes);
  for (int press = 0; press < 4; ++press) {
    board_.reset(mcu::ResetSource::power_on);
    board_.run_for(5'000);
    ASSERT_FALSE(board_.usb_connected()) << "the image is being checked";
    press_reset_button();
    EXPECT_LT(wait_for_usb(), 1);
    EXPECT_EQ(trial_.failures(), 0u) << press;
  }
  for (int press = 0; press < 4; ++press) {
    detach();
    press_reset_button();
    EXPECT_EQ(trial_.failures(), 0u) << press;
  }
  ASSERT_EQ(plug_in(board_), protocol::usb::product_id);
  EXPECT_EQ(trial_.failures(), 0u);
  EXPECT_TRUE(holds(running, image_of(next_version_).bytes));
  press_reset_button();
  wait_for_usb();
  EXPECT_EQ(trial_.failures(), 1u) << "in the program it counts";
}

TEST_F(TrialOnTheBoard, AnImageProvesItselfByAHostAndTenSecondsAndIsKeptFromThenOn) {
  install(image_of(next_version_).bytes);
  board_.run_for(12'000'000);
  EXPECT_TRUE(trial_.open()) << "no host has reached it";
  {
    instrument::Session session(test::connect(board_));
    session.request(protocol::GetStatus{});
  }
  board_.run_for(20'000);
  EXPECT_FALSE(trial_.open());
  for (int i = 0; i < 4; ++i) {
    board_.chip().stand_still(500'000 * mcu::time_per_us);
    board_.run_for(1'000'000);
  }
  EXPECT_EQ(board_.chip().watchdog_resets(), 4u);
  EXPECT_TRUE(holds(running, image_of(next_version_).bytes));
}

TEST_F(TrialOnTheBoard, AProofThatFlashDoesNotTakeIsAFaultOnceAStart) {
  install(image_of(next_version_).bytes);
  constexpr std::uint32_t sector_of_running = 1u << 5;
  board_.chip().protect_flash(sector_of_running);
  constexpr auto internal = static_cast<std::uint8_t>(Fault::internal);
  for (int start = 0; start < 2; ++start) {
    wait_for_usb();
    instrument::Session session(test::connect(board_));
    EXPECT_EQ(session.request(protocol::GetStatus{}).fault, 0);
    board_.run_for(11'000'000);
    EXPECT_EQ(session.request(protocol::GetStatus{}).fault, internal) << start;
    const auto entry = newest_log(session);
    EXPECT_EQ(entry.fault, internal);
    EXPECT_EQ(entry.boot_id, session.device().boot_id);
    EXPECT_THAT(instrument::fault_detail(entry.fault, entry.detail), HasSubstr("stays on trial"));
    session.request(protocol::ClearFault{internal});
    board_.run_for(1'000'000);
    EXPECT_EQ(session.request(protocol::GetStatus{}).fault, 0);
    EXPECT_TRUE(trial_.open());
    board_.reset(mcu::ResetSource::power_on);
  }
  board_.chip().protect_flash(0);
  wait_for_usb();
  instrument::Session session(test::connect(board_));
  session.request(protocol::GetStatus{});
  board_.run_for(11'000'000);
  EXPECT_EQ(session.request(protocol::GetStatus{}).fault, 0);
  EXPECT_FALSE(trial_.open());
}

TEST_F(TrialOnTheBoard, AHostAloneDoesNotProveAnImageThatHangsSoonAfter) {
  install(image_of(next_version_).bytes);
  for (std::uint32_t start = 0; start < 3; ++start) {
    wait_for_usb();
    ASSERT_EQ(trial_.failures(), start);
    instrument::Session session(test::connect(board_));
    EXPECT_EQ(session.request(protocol::GetStatus{}).fault,
              start == 0 ? 0 : static_cast<std::uint8_t>(Fault::watchdog));
    board_.run_for(5'000'000);
    EXPECT_TRUE(trial_.open());
    board_.chip().stand_still(500'000 * mcu::time_per_us);
    board_.run_for(300'000);
  }
  wait_for_usb();
  expect_rolled_back("the watchdog");
}

TEST_F(TrialOnTheBoard, WithNothingToGoBackToTheBootLoaderSaysSoAndTakesAnother) {
  install(hanging(next_version_));
  places_.erase(Place::previous);
  EXPECT_LT(wait_for_usb(), 20);
  ASSERT_EQ(plug_in(board_), protocol::usb::update_product_id);
  EXPECT_THAT(instrument::dfu_trouble(dfu_), HasSubstr("failed its trial"));
  board_.reset(mcu::ResetSource::power_on);
  ASSERT_EQ(plug_in(board_), protocol::usb::update_product_id) << "no power cycle starts it again";
  EXPECT_THAT(instrument::dfu_trouble(dfu_), HasSubstr("failed its trial"));
  instrument::dfu_download(dfu_, old_.bytes);
  instrument::dfu_leave(dfu_);
  board_.run_for(5'000);
  EXPECT_EQ(plug_in(board_), protocol::usb::product_id) << "older than the one that failed";
}

/// Every byte of it is cut in tests/unit/boot, by the same code.
TEST_F(TrialOnTheBoard, APowerCutDuringARollBackOnlyPutsItOff) {
  const Bytes bad = crashing(next_version_);
  install(bad);
  ASSERT_TRUE(wait_until_gone(bad));
  const std::uint64_t begin_us = board_.now_us();
  wait_for_usb();
  const std::uint64_t lasts_us = board_.now_us() - begin_us;
  EXPECT_GT(lasts_us, 300'000u) << "the copy: the erasure is an instant to whoever looks on";
  for (int cut = 0; cut < 5; ++cut) {
    install(bad);
    ASSERT_TRUE(wait_until_gone(bad));
    board_.run_for(lasts_us * static_cast<unsigned>(cut) / 5);
    board_.reset(mcu::ResetSource::power_on);
    wait_for_usb();
    SCOPED_TRACE(cut);
    expect_rolled_back("it crashed");
  }
}

TEST_F(TrialOnTheBoard, WhereTheImageBeforeCannotBeKeptTheNewOneRunsAndBothEndsSaySo) {
  constexpr std::uint32_t sector_of_previous = 1u << 7;
  board_.chip().protect_flash(sector_of_previous);
  detach();
  const auto newer = image_of(next_version_);
  EXPECT_THAT(instrument::dfu_download(dfu_, newer.bytes), HasSubstr("could not be kept"));
  instrument::dfu_leave(dfu_);
  for (const bool first : {true, false}) {
    board_.run_for(5'000);
    EXPECT_LT(wait_for_usb(), 1) << "no start tries what cannot be";
    EXPECT_TRUE(holds(running, newer.bytes));
    instrument::Session session(test::connect(board_));
    constexpr auto no_fallback = static_cast<std::uint8_t>(Fault::no_fallback);
    EXPECT_EQ(session.request(protocol::GetStatus{}).fault, first ? no_fallback : 0);
    const auto entry = newest_log(session);
    EXPECT_EQ(entry.fault, no_fallback);
    EXPECT_THAT(instrument::fault_detail(entry.fault, entry.detail), HasSubstr("nothing could"));
    board_.reset(mcu::ResetSource::power_on);
  }
}

}  // namespace
}  // namespace umov
