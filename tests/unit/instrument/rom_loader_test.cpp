// Writing a chip by the loader in its ROM: the host's half against a model of AN3156.
#include "host/instrument/rom_loader.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "protocol/dfu.hpp"
#include "tests/unit/failure.hpp"

namespace umov::instrument {
namespace {

namespace dfu = protocol::dfu;
using Bytes = std::vector<std::uint8_t>;
using ::testing::HasSubstr;

/// The loader's rules: commands in block 0, data from block 2 on at the address pointer, work done
/// between the first and the second DFU_GETSTATUS, flash that has to be erased before it is
/// written.
class RomLoader final : public DfuPipe {
 public:
  RomLoader() : flash(1 << 20, 0x5A) {}

  Answer read(std::uint8_t request, std::uint16_t, std::size_t) override {
    if (request != dfu::get_status) return {};
    if (state == dfu::State::download_sync) {
      state = dfu::State::download_busy;
    } else if (state == dfu::State::download_busy) {
      EXPECT_GE(waited_ms, 50) << "asked again too soon";
      state = status == dfu::Status::ok ? dfu::State::download_idle : dfu::State::error;
    }
    waited_ms = 0;
    const std::uint8_t poll_ms = state == dfu::State::download_busy ? 50 : 0;
    return {
        true,
        {static_cast<std::uint8_t>(status), poll_ms, 0, 0, static_cast<std::uint8_t>(state), 0}};
  }
  bool write(std::uint8_t request, std::uint16_t block,
             std::span<const std::uint8_t> bytes) override {
    switch (request) {
      case dfu::clear_status:
        status = dfu::Status::ok;
        state = dfu::State::idle;
        return true;
      case dfu::abort:
        state = dfu::State::idle;
        return true;
      case dfu::download:
        break;
      default:
        return false;
    }
    if (state != dfu::State::idle && state != dfu::State::download_idle) return false;
    state = dfu::State::download_sync;
    if (block == 0) {
      command(bytes);
    } else if (block >= 2 && bytes.size() <= rom::transfer_bytes) {
      store(pointer + (block - 2u) * static_cast<std::uint32_t>(rom::transfer_bytes), bytes);
    }
    return true;
  }
  void wait(std::chrono::milliseconds duration) override { waited_ms += duration.count(); }
  std::string text(std::uint8_t) override { return {}; }
  std::string name() const override { return "ROM loader"; }

  Bytes flash;
  std::vector<std::uint32_t> erased;
  bool protected_flash = false;
  dfu::State state = dfu::State::idle;
  dfu::Status status = dfu::Status::ok;

 private:
  void command(std::span<const std::uint8_t> bytes) {
    ASSERT_EQ(bytes.size(), 5u);
    const std::uint32_t address = bytes[1] | static_cast<std::uint32_t>(bytes[2]) << 8 |
                                  static_cast<std::uint32_t>(bytes[3]) << 16 |
                                  static_cast<std::uint32_t>(bytes[4]) << 24;
    if (protected_flash) {
      status = dfu::Status::vendor;  // AN3156: errVENDOR under read-out protection
      return;
    }
    if (bytes[0] == 0x21) {
      pointer = address;
    } else if (bytes[0] == 0x41) {
      static const std::map<std::uint32_t, std::size_t> sizes = {
          {0x08000000, 16384}, {0x08004000, 16384},  {0x08008000, 16384}, {0x0800C000, 16384},
          {0x08010000, 65536}, {0x08020000, 131072}, {0x08040000, 131072}};
      ASSERT_TRUE(sizes.contains(address)) << "no sector begins there";
      erased.push_back(address);
      std::fill_n(flash.begin() + (address - 0x08000000), sizes.at(address), std::uint8_t{0xFF});
    } else {
      status = dfu::Status::stalled_packet;
    }
  }
  void store(std::uint32_t address, std::span<const std::uint8_t> bytes) {
    for (const std::uint8_t byte : bytes) {
      std::uint8_t& cell = flash.at(address++ - 0x08000000);
      EXPECT_EQ(cell, 0xFF) << "written without being erased";
      cell = static_cast<std::uint8_t>(cell & byte);
    }
  }

  std::uint32_t pointer = 0;
  std::int64_t waited_ms = 0;
};

Bytes noise(std::size_t size) {
  Bytes bytes(size);
  for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::uint8_t>(i * 31 + i / 256);
  return bytes;
}

TEST(RomLoader, BootLoaderAndImageAreWrittenAndNothingElseIsErased) {
  RomLoader loader;
  const Bytes boot = noise(19'001), image = noise(75'536);
  std::size_t told = 0;
  rom_write(loader, rom::boot_loader_address, boot);
  rom_write(loader, rom::image_address, image,
            [&](UpdatePhase, std::size_t done, std::size_t) { told = done; });
  EXPECT_EQ(told, image.size());
  EXPECT_EQ(loader.erased, (std::vector<std::uint32_t>{0x08000000, 0x08004000, 0x08020000}));
  EXPECT_TRUE(std::equal(boot.begin(), boot.end(), loader.flash.begin()));
  EXPECT_TRUE(std::equal(image.begin(), image.end(), loader.flash.begin() + 0x20000));
  EXPECT_EQ(loader.flash[0x8000], 0x5A) << "settings and log stay";
  EXPECT_EQ(loader.state, dfu::State::idle);
}

TEST(RomLoader, AnUpdateThatWaitsToBeInstalledIsErasedBeforeTheImageIsWritten) {
  RomLoader loader;
  const Bytes boot = noise(19'001), image = noise(75'536);
  rom_flash(loader, boot, image);
  EXPECT_EQ(loader.erased,
            (std::vector<std::uint32_t>{0x08040000, 0x08000000, 0x08004000, 0x08020000}));
  EXPECT_EQ(loader.flash[0x5FFFC], 0xFF) << "the mark";
  EXPECT_TRUE(std::equal(boot.begin(), boot.end(), loader.flash.begin()));
  EXPECT_TRUE(std::equal(image.begin(), image.end(), loader.flash.begin() + 0x20000));
  EXPECT_EQ(loader.flash[0x60000], 0x5A) << "the image before it stays";
  loader.erased.clear();
  rom_flash(loader, {}, image);
  EXPECT_EQ(loader.erased, (std::vector<std::uint32_t>{0x08040000, 0x08020000}));
}

TEST(RomLoader, WhatAnotherProgramLeftUnfinishedIsEndedFirst) {
  for (const auto state : {dfu::State::error, dfu::State::download_idle, dfu::State::upload_idle}) {
    RomLoader loader;
    loader.state = state;
    if (state == dfu::State::error) loader.status = dfu::Status::stalled_packet;
    rom_write(loader, rom::image_address, noise(5'000));
    EXPECT_EQ(loader.erased.size(), 1u);
  }
}

TEST(RomLoader, ARefusalAndAnImageThatDoesNotFitAreOneClearMessage) {
  RomLoader loader;
  loader.protected_flash = true;
  EXPECT_THAT(failure_of([&] { rom_write(loader, rom::image_address, noise(5'000)); }),
              HasSubstr("refuses the update: DFU status 11"));
  EXPECT_THAT(failure_of([&] { rom_write(loader, 0x080F'F000, noise(5'000)); }),
              HasSubstr("does not fit the flash"));
}

}  // namespace
}  // namespace umov::instrument
