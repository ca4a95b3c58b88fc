// Files with a controller's program: read, checked, signed.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "protocol/image_header.hpp"

namespace umov::instrument {

struct FirmwareImage {
  protocol::ImageHeader header{};
  std::vector<std::uint8_t> bytes;  ///< header and program, as the boot loader takes them
};

/// Reads umov-….bin or .dfu. Throws umov::Error when the file is no image, is cut off, or fails a
/// CRC.
FirmwareImage read_firmware_image(const std::string& path);

/// "0.1.0".
std::string version_text(std::uint32_t version);
/// Throws umov::Error when `text` is not MAJOR.MINOR.PATCH, each part in its range.
std::uint32_t version_from_text(const std::string& text);

/// What an Ed25519 key is made from.
using KeySeed = std::array<std::uint8_t, 32>;

/// Reads a key file: one line "seed = " with 64 hexadecimal digits, lines that begin with #.
KeySeed read_key(const std::string& path);
/// Makes a key from the system's source of randomness and writes it to a file that only its owner
/// may read. Throws umov::Error when the file exists: a key is never overwritten.
void make_key(const std::string& path);
std::array<std::uint8_t, 32> public_key(const KeySeed& seed);

/// Signs the image anew, with its header as it stands in `image.header`.
void sign_image(FirmwareImage& image, const KeySeed& seed);
bool signed_by(const FirmwareImage& image, const std::array<std::uint8_t, 32>& key);

/// The file as dfu-util wants it: with the suffix of DFU 1.1, appendix B.
std::vector<std::uint8_t> with_dfu_suffix(std::span<const std::uint8_t> image);

}  // namespace umov::instrument
