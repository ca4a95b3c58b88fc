// Writing the chip's flash: erase a sector, program words. The bank cannot be read meanwhile: the
// core stands still, 16 us a word (typical), about a second for the erasure of 128 KB.
#pragma once

#include <cstdint>
#include <span>

namespace umov::boards::stm32f407 {

/// Flash map. One link address: the running image is in sector 5.
struct FlashArea {
  unsigned sector;
  std::uintptr_t address;
  std::uint32_t size;
};
inline constexpr FlashArea settings_area_a{2, 0x0800'8000, 16 * 1024};
inline constexpr FlashArea settings_area_b{3, 0x0800'C000, 16 * 1024};
inline constexpr FlashArea log_area{4, 0x0801'0000, 64 * 1024};
inline constexpr FlashArea image_area{5, 0x0802'0000, 128 * 1024};
inline constexpr FlashArea staged_area{6, 0x0804'0000, 128 * 1024};
inline constexpr FlashArea previous_area{7, 0x0806'0000, 128 * 1024};

/// False when the chip reports an error (write protection, wrong sequence).
bool erase(const FlashArea& area);
/// Programs words to `address` (a multiple of 4, erased before); false as above, or when what is
/// read back differs.
bool program(std::uintptr_t address, std::span<const std::uint32_t> words);

}  // namespace umov::boards::stm32f407
