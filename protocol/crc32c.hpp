// CRC-32C (Castagnoli): reflected polynomial 0x82F63B78, initial value and final exclusive-or all
// ones; check value 0xE3069283 for the nine bytes "123456789". Freestanding C++20, no heap.
#pragma once

#include <array>
#include <cstdint>
#include <span>

namespace umov::protocol {

namespace crc32c_detail {

constexpr std::array<std::uint32_t, 256> make_table() {
  constexpr std::uint32_t reflected_polynomial = 0x82F63B78u;
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t byte = 0; byte < 256; ++byte) {
    std::uint32_t remainder = byte;
    for (int bit = 0; bit < 8; ++bit) {
      remainder = (remainder >> 1) ^ ((remainder & 1u) != 0u ? reflected_polynomial : 0u);
    }
    table[byte] = remainder;
  }
  return table;
}

/// One kilobyte of read-only memory.
inline constexpr std::array<std::uint32_t, 256> table = make_table();

}  // namespace crc32c_detail

/// CRC of `bytes`; give the CRC of what came before as `preceding` to go on piece by piece.
constexpr std::uint32_t crc32c(std::span<const std::uint8_t> bytes, std::uint32_t preceding = 0) {
  std::uint32_t crc = ~preceding;
  for (const std::uint8_t byte : bytes) {
    crc = (crc >> 8) ^ crc32c_detail::table[(crc ^ byte) & 0xffu];
  }
  return ~crc;
}

}  // namespace umov::protocol
