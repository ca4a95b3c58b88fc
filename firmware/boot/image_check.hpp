// Whether what lies in flash may run.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "firmware/boot/ed25519.hpp"
#include "protocol/image_header.hpp"

namespace umov::firmware::boot {

using protocol::ImageHeader;

/// In the order in which it is looked at.
enum class Verdict : std::uint8_t {
  good,
  no_image,       ///< no header, or more than the place holds
  wrong_board,    ///< for other hardware
  damaged,        ///< fails its CRC
  bad_signature,  ///< signed by nobody this board trusts
};

/// What a boot loader was built to accept.
struct Trust {
  std::string_view board;
  PublicKey key{};
};

/// Looks at the header alone: good, no_image or wrong_board. `room`: bytes that the place has.
Verdict check_header(std::span<const std::uint8_t> bytes, std::size_t room, const Trust& trust,
                     ImageHeader& header);

/// Looks at all of the image at the beginning of `place`. `header` is filled unless the verdict is
/// no_image.
Verdict check_image(std::span<const std::uint8_t> place, const Trust& trust, ImageHeader& header);

}  // namespace umov::firmware::boot
