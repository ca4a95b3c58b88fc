// Whether what lies in flash may run.
#pragma once

#include <cstdint>
#include <optional>
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

/// Whether header and CRC of the image at the beginning of `place` are right: what was stored is
/// what was sent, whoever made it.
bool is_whole(std::span<const std::uint8_t> place, const Trust& trust);

/// Looks at all of the image at the beginning of `place`, in pieces, so that a USB host is not kept
/// waiting: some 100 instructions a byte, and a few millions at the end.
class ImageCheck {
 public:
  ImageCheck(std::span<const std::uint8_t> place, const Trust& trust)
      : place_(place), trust_(&trust) {}
  /// One piece; false when the verdict stands.
  bool step();
  Verdict verdict() const { return verdict_; }
  /// Filled unless the verdict is no_image.
  const ImageHeader& header() const { return header_; }

 private:
  std::span<const std::uint8_t> place_;
  const Trust* trust_;
  ImageHeader header_{};
  std::optional<SignatureCheck> signature_;
  std::span<const std::uint8_t> rest_{};
  Verdict verdict_ = Verdict::no_image;
};

/// The same at once.
Verdict check_image(std::span<const std::uint8_t> place, const Trust& trust);

}  // namespace umov::firmware::boot
