#include "host/instrument/rom_loader.hpp"

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "protocol/dfu.hpp"

namespace umov::instrument {
namespace {

namespace dfu = protocol::dfu;

/// AN3156: commands travel as block 0, data as block 2 and up, counted from the address pointer.
constexpr std::uint16_t command_block = 0, first_data_block = 2;
constexpr std::uint8_t set_address_command = 0x21, erase_command = 0x41;

struct Sector {
  std::uint32_t begin, size;
};

/// RM0090, table 5: four of 16 KB, one of 64 KB, seven of 128 KB.
std::vector<Sector> sectors() {
  std::vector<Sector> all;
  std::uint32_t at = rom::flash_begin;
  for (int i = 0; i < 12; ++i) {
    const std::uint32_t kb = i < 4 ? 16 : i == 4 ? 64 : 128;
    all.push_back({at, kb * 1024});
    at += kb * 1024;
  }
  return all;
}

void download(DfuPipe& loader, std::uint16_t block, std::span<const std::uint8_t> bytes) {
  if (!loader.write(dfu::download, block, bytes)) throw_update_refused(loader);
  wait_for_state(loader, dfu::State::download_idle);
}

void command(DfuPipe& loader, std::uint8_t code, std::uint32_t address) {
  const std::array<std::uint8_t, 5> bytes = {
      code, static_cast<std::uint8_t>(address), static_cast<std::uint8_t>(address >> 8),
      static_cast<std::uint8_t>(address >> 16), static_cast<std::uint8_t>(address >> 24)};
  download(loader, command_block, bytes);
}

/// Every sector that these bytes touch.
void erase(DfuPipe& loader, std::uint32_t address, std::size_t size) {
  const auto end = address + static_cast<std::uint32_t>(size);
  for (const Sector& sector : sectors()) {
    if (sector.begin < end && sector.begin + sector.size > address) {
      command(loader, erase_command, sector.begin);
    }
  }
}

}  // namespace

void rom_write(DfuPipe& loader, std::uint32_t address, std::span<const std::uint8_t> bytes,
               const UpdateProgress& progress) {
  if (address < rom::flash_begin || address > rom::flash_end ||
      bytes.size() > rom::flash_end - address) {
    throw Error({loader.name()}, "the image does not fit the flash of the chip",
                "give an image of this board");
  }
  make_dfu_idle(loader);
  erase(loader, address, bytes.size());
  command(loader, set_address_command, address);
  std::uint16_t block = first_data_block;
  for (std::size_t at = 0; at < bytes.size(); ++block) {
    const std::size_t size = std::min(rom::transfer_bytes, bytes.size() - at);
    download(loader, block, bytes.subspan(at, size));
    at += size;
    if (progress) progress(UpdatePhase::sending, at, bytes.size());
  }
  make_dfu_idle(loader);
}

void rom_flash(DfuPipe& loader, std::span<const std::uint8_t> boot_loader,
               std::span<const std::uint8_t> image, const UpdateProgress& progress) {
  make_dfu_idle(loader);
  erase(loader, rom::staged_address, rom::image_room);
  if (!boot_loader.empty()) rom_write(loader, rom::boot_loader_address, boot_loader, progress);
  rom_write(loader, rom::image_address, image, progress);
}

}  // namespace umov::instrument
