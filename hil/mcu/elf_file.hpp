// What an ELF file for ARM puts where.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace umov::mcu {

struct Segment {
  std::uint32_t address = 0;  ///< where it is loaded (physical address)
  std::vector<std::uint8_t> bytes;
};

/// The loadable segments of a 32-bit little-endian ARM executable. Throws umov::Error for a file
/// that can't be read or is none.
std::vector<Segment> read_elf(const std::string& path);

}  // namespace umov::mcu
