// What stands before a controller's program in flash and in a file: for which board it is, how old,
// how long, and who vouches for it. Freestanding C++20, no heap.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "protocol/crc32c.hpp"

namespace umov::protocol {

/// 512 bytes, so that the program's vectors behind it lie where the processor wants them; integers
/// little-endian:
///
///   0    8   "UMOVFW01"
///   8    4   bytes of this header, 512
///   12   4   bytes of the program behind it, a multiple of 4
///   16   24  board, ASCII, padded with zeros
///   40   4   version: major << 16 | minor << 8 | patch
///   44   4   zero
///   48   8   hash of the program's sources, as told at the handshake
///   56   4   CRC-32C of the program
///   60   4   CRC-32C of bytes 0 to 59
///   64   64  Ed25519 signature of bytes 0 to 63 and the program
///   128  384 not looked at (ones)
struct ImageHeader {
  static constexpr std::size_t bytes = 512;
  static constexpr std::size_t signed_bytes = 64;  ///< of the header, before the program
  static constexpr std::size_t crc_offset = 60;
  static constexpr std::size_t signature_offset = 64;
  static constexpr std::string_view magic = "UMOVFW01";

  std::uint32_t program_bytes = 0;
  std::array<char, 24> board{};
  std::uint32_t version = 0;
  std::uint64_t source_hash = 0;
  std::uint32_t program_crc = 0;
  std::array<std::uint8_t, 64> signature{};

  constexpr std::uint32_t image_bytes() const {
    return static_cast<std::uint32_t>(bytes) + program_bytes;
  }
  constexpr std::string_view board_name() const {
    const std::string_view name(board.data(), board.size());
    return name.substr(0, name.find('\0'));
  }
};

/// Parts below 65536, 256, 256.
constexpr std::uint32_t image_version(unsigned major, unsigned minor, unsigned patch) {
  return major << 16 | minor << 8 | patch;
}

namespace image_detail {

template <class T>
constexpr T number(std::span<const std::uint8_t> from, std::size_t offset) {
  T value = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i) value |= T{from[offset + i]} << (8 * i);
  return value;
}

template <class T>
constexpr void put(std::span<std::uint8_t> to, std::size_t offset, T value) {
  for (std::size_t i = 0; i < sizeof(T); ++i) {
    to[offset + i] = static_cast<std::uint8_t>(value >> (8 * i));
  }
}

}  // namespace image_detail

/// False when the bytes are no header: too few, wrong beginning, length or CRC.
constexpr bool read_image_header(std::span<const std::uint8_t> from, ImageHeader& header) {
  using namespace image_detail;
  if (from.size() < ImageHeader::bytes) return false;
  for (std::size_t i = 0; i < ImageHeader::magic.size(); ++i) {
    if (from[i] != static_cast<std::uint8_t>(ImageHeader::magic[i])) return false;
  }
  if (number<std::uint32_t>(from, 8) != ImageHeader::bytes ||
      number<std::uint32_t>(from, ImageHeader::crc_offset) !=
          crc32c(from.first(ImageHeader::crc_offset))) {
    return false;
  }
  header.program_bytes = number<std::uint32_t>(from, 12);
  for (std::size_t i = 0; i < header.board.size(); ++i) {
    header.board[i] = static_cast<char>(from[16 + i]);
  }
  header.version = number<std::uint32_t>(from, 40);
  header.source_hash = number<std::uint64_t>(from, 48);
  header.program_crc = number<std::uint32_t>(from, 56);
  for (std::size_t i = 0; i < header.signature.size(); ++i) {
    header.signature[i] = from[ImageHeader::signature_offset + i];
  }
  return header.program_bytes % 4 == 0;
}

/// Writes the header to the first 512 bytes of `to`, its own CRC included.
constexpr void write_image_header(const ImageHeader& header, std::span<std::uint8_t> to) {
  using namespace image_detail;
  for (std::size_t i = 0; i < ImageHeader::bytes; ++i) to[i] = 0xFF;
  for (std::size_t i = 0; i < ImageHeader::magic.size(); ++i) {
    to[i] = static_cast<std::uint8_t>(ImageHeader::magic[i]);
  }
  put(to, 8, static_cast<std::uint32_t>(ImageHeader::bytes));
  put(to, 12, header.program_bytes);
  for (std::size_t i = 0; i < header.board.size(); ++i) {
    to[16 + i] = static_cast<std::uint8_t>(header.board[i]);
  }
  put(to, 40, header.version);
  put(to, 44, std::uint32_t{0});
  put(to, 48, header.source_hash);
  put(to, 56, header.program_crc);
  put(to, ImageHeader::crc_offset, crc32c(to.first(ImageHeader::crc_offset)));
  for (std::size_t i = 0; i < header.signature.size(); ++i) {
    to[ImageHeader::signature_offset + i] = header.signature[i];
  }
}

}  // namespace umov::protocol
