// CRC-32C (Castagnoli), the check of journal frames.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace umov::formats {

/// CRC-32C with the usual initial value and final inversion: crc32c("123456789") = 0xe3069283.
std::uint32_t crc32c(std::span<const std::byte> bytes);

}  // namespace umov::formats
