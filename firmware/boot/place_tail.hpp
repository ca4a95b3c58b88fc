// The last 64 bytes of each place, which no image may take: words in which boot loader and program
// mark what has become of the image.
//
//   running   0      on trial              see trial.hpp
//             1-3    starts that failed
//             4      confirmed
//   staged    0-11   four notes            see notes.hpp
//             15     ordered, carried out  see installer.hpp
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "firmware/boot/port.hpp"

namespace umov::firmware::boot {

inline constexpr std::uint32_t tail_words = 16;
/// Bytes of a place that are not for its image.
inline constexpr std::uint32_t reserved_bytes = 4 * tail_words;
inline constexpr std::uint32_t erased_word = 0xFFFF'FFFF;

/// Word 0 to 15 of the tail.
inline std::uint32_t tail_word(const Flash& flash, Place place, std::uint32_t word) {
  const auto bytes = flash.contents(place).last(reserved_bytes).subspan(4 * word, 4);
  return std::uint32_t{bytes[0]} | std::uint32_t{bytes[1]} << 8 | std::uint32_t{bytes[2]} << 16 |
         std::uint32_t{bytes[3]} << 24;
}

/// False when the flash fails. Bits can only be cleared.
inline bool write_tail(Flash& flash, Place place, std::uint32_t word, std::uint32_t value) {
  const std::array bytes = {static_cast<std::uint8_t>(value), static_cast<std::uint8_t>(value >> 8),
                            static_cast<std::uint8_t>(value >> 16),
                            static_cast<std::uint8_t>(value >> 24)};
  const auto size = static_cast<std::uint32_t>(flash.contents(place).size());
  return flash.program(place, size - reserved_bytes + 4 * word, bytes);
}

}  // namespace umov::firmware::boot
