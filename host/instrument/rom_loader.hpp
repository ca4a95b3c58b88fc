// The boot loader that ST puts into every STM32 (AN2606), over USB: DFU with the extensions of
// AN3156. It needs no program in the chip and checks nothing; BOOT0 held high at a reset starts it.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>

#include "host/instrument/dfu_client.hpp"

namespace umov::instrument {

/// Addresses of the STM32F407 (RM0090, table 5; boards/stm32f407/image.ld).
namespace rom {
inline constexpr std::uint32_t flash_begin = 0x0800'0000, flash_end = 0x0810'0000;
inline constexpr std::uint32_t boot_loader_address = flash_begin, boot_loader_room = 32 * 1024;
inline constexpr std::uint32_t image_address = 0x0802'0000, image_room = 128 * 1024;
/// Where the boot loader keeps an image that it has received, marked when it is to be installed.
inline constexpr std::uint32_t staged_address = 0x0804'0000;
/// wTransferSize of the ROM loader.
inline constexpr std::size_t transfer_bytes = 2048;
}  // namespace rom

/// Erases the sectors that `bytes` touch and writes them. Throws umov::Error when they do not lie
/// in the flash, UpdateRefused when the loader refuses (read-out protection), LinkLost.
void rom_write(DfuPipe& loader, std::uint32_t address, std::span<const std::uint8_t> bytes,
               const UpdateProgress& progress = {});

/// Writes the boot loader, unless it is empty, and the image. An update that waits to be installed
/// is erased first: else the next start would put it over this image. Throws as rom_write().
void rom_flash(DfuPipe& loader, std::span<const std::uint8_t> boot_loader,
               std::span<const std::uint8_t> image, const UpdateProgress& progress = {});

/// The ROM loader of the chip that is plugged in, waited for; throws umov::Error when none appears,
/// or more than one.
std::unique_ptr<DfuPipe> open_rom_loader(std::chrono::seconds limit);

}  // namespace umov::instrument
