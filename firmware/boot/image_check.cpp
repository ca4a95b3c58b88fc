#include "firmware/boot/image_check.hpp"

#include "protocol/crc32c.hpp"

namespace umov::firmware::boot {

Verdict check_header(std::span<const std::uint8_t> bytes, std::size_t room, const Trust& trust,
                     ImageHeader& header) {
  if (!protocol::read_image_header(bytes, header)) return Verdict::no_image;
  // The stack pointer and the first instruction at least.
  if (header.program_bytes < 8 || header.program_bytes > room - ImageHeader::bytes) {
    return Verdict::no_image;
  }
  return header.board_name() == trust.board ? Verdict::good : Verdict::wrong_board;
}

Verdict check_image(std::span<const std::uint8_t> place, const Trust& trust, ImageHeader& header) {
  const Verdict head = check_header(place, place.size(), trust, header);
  if (head != Verdict::good) return head;
  const auto program = place.subspan(ImageHeader::bytes, header.program_bytes);
  if (protocol::crc32c(program) != header.program_crc) return Verdict::damaged;
  SignatureCheck signature(trust.key, header.signature);
  signature.update(place.first(ImageHeader::signed_bytes));
  signature.update(program);
  return signature.good() ? Verdict::good : Verdict::bad_signature;
}

}  // namespace umov::firmware::boot
