// The flashed image behind its boot loader on the emulated chip, with a host's half of DFU on its
// USB cable.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "hil/mcu/board/mcu_board.hpp"
#include "host/instrument/dfu_client.hpp"
#include "host/instrument/firmware_image.hpp"
#include "protocol/dfu.hpp"
#include "tests/unit/mcu_board/noisy_stages.hpp"
#include "tests/unit/mcu_board/scan_run.hpp"
#include "tests/unit/mcu_board/usb_cable.hpp"

namespace umov::test {

/// Where the boot loader's three places lie in the flash.
constexpr std::uint32_t running = 0x2'0000, staged = 0x4'0000, previous = 0x6'0000,
                        place_bytes = 0x2'0000;

inline instrument::KeySeed development_key() {
  return instrument::read_key(UMOV_SOURCE_DIR "/firmware/boot/development.key");
}

/// The DFU interface of whatever the chip runs.
class DfuOfTheBoard final : public instrument::DfuPipe {
 public:
  DfuOfTheBoard(mcu::McuBoard& board, UsbCable& cable, std::uint16_t interface)
      : board_(&board), cable_(&cable), interface_(interface) {}
  Answer read(std::uint8_t request, std::uint16_t value, std::size_t length) override {
    const auto got =
        cable_->control(0xA1, request, value, interface_, static_cast<std::uint16_t>(length));
    return {got.ok(), got.bytes};
  }
  bool write(std::uint8_t request, std::uint16_t value,
             std::span<const std::uint8_t> bytes) override {
    return cable_
        ->control(0x21, request, value, interface_, static_cast<std::uint16_t>(bytes.size()),
                  {bytes.begin(), bytes.end()})
        .ok();
  }
  void wait(std::chrono::milliseconds duration) override {
    board_->run_for(1000 * static_cast<std::uint64_t>(duration.count()));
  }
  std::string text(std::uint8_t index) override {
    const auto got =
        cable_->control(0x80, 6, static_cast<std::uint16_t>(0x0300 | index), 0x409, 255);
    std::string ascii;
    for (std::size_t i = 2; i < got.bytes.size(); i += 2)
      ascii.push_back(static_cast<char>(got.bytes[i]));
    return ascii;
  }
  std::string name() const override { return "emulated board"; }

 private:
  mcu::McuBoard* board_;
  UsbCable* cable_;
  std::uint16_t interface_;
};

class BoardWithBootLoader : public testing::Test {
 protected:
  static std::string image_file() {
    return std::filesystem::path(UMOV_STM32F407_ELF).replace_extension(".bin");
  }
  /// What the build made, as another version.
  static instrument::FirmwareImage image_of(std::uint32_t version) {
    instrument::FirmwareImage image = instrument::read_firmware_image(image_file());
    image.header.version = version;
    instrument::sign_image(image, development_key());
    return image;
  }
  std::uint16_t product() {
    const auto device = cable_.control(0x80, 6, 0x0100, 0, 18).bytes;
    return device.size() < 18 ? std::uint16_t{0}
                              : static_cast<std::uint16_t>(device[10] | device[11] << 8);
  }
  /// Waits for whatever comes up, and configures it; its product id.
  std::uint16_t plug_in(mcu::McuBoard& board) {
    for (int i = 0; i < 500 && !board.usb_connected(); ++i) board.run_for(10'000);
    board.run_for(5'000);
    EXPECT_TRUE(cable_.plug_in());
    return product();
  }
  void put(std::uint32_t offset, const Bytes& image) {
    std::copy(image.begin(), image.end(),
              board_.chip().flash_contents().begin() + static_cast<std::ptrdiff_t>(offset));
  }
  bool holds(std::uint32_t offset, const Bytes& image) {
    return std::equal(image.begin(), image.end(),
                      board_.chip().flash_contents().begin() + static_cast<std::ptrdiff_t>(offset));
  }
  /// From the program to the boot loader.
  void detach() {
    ASSERT_EQ(plug_in(board_), protocol::usb::product_id);
    ASSERT_TRUE(cable_.control(0x21, protocol::dfu::detach, 1000, 3, 0).ok());
    board_.run_for(5'000);
    ASSERT_EQ(plug_in(board_), protocol::usb::update_product_id);
  }

  NoisyBench bench_;
  mcu::McuBoard board_{bench_,
                       {.image = UMOV_STM32F407_ELF, .boot_loader = UMOV_STM32F407_BOOT_ELF}};
  UsbCable cable_{board_};
  DfuOfTheBoard dfu_{board_, cable_, 0};
};

}  // namespace umov::test
