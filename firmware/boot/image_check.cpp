#include "firmware/boot/image_check.hpp"

#include <algorithm>

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

bool is_whole(std::span<const std::uint8_t> place, const Trust& trust) {
  ImageHeader header;
  return check_header(place, place.size(), trust, header) == Verdict::good &&
         protocol::crc32c(place.subspan(ImageHeader::bytes, header.program_bytes)) ==
             header.program_crc;
}

bool ImageCheck::step() {
  if (!signature_) {
    verdict_ = check_header(place_, place_.size(), *trust_, header_);
    if (verdict_ != Verdict::good) return false;
    if (!is_whole(place_, *trust_)) {
      verdict_ = Verdict::damaged;
      return false;
    }
    signature_.emplace(trust_->key, header_.signature);
    signature_->update(place_.first(ImageHeader::signed_bytes));
    rest_ = place_.subspan(ImageHeader::bytes, header_.program_bytes);
    return true;
  }
  if (!rest_.empty()) {
    constexpr std::size_t piece_bytes = 2048;
    const auto piece = rest_.first(std::min(piece_bytes, rest_.size()));
    signature_->update(piece);
    rest_ = rest_.subspan(piece.size());
    return true;
  }
  verdict_ = signature_->good() ? Verdict::good : Verdict::bad_signature;
  return false;
}

Verdict check_image(std::span<const std::uint8_t> place, const Trust& trust) {
  ImageCheck check(place, trust);
  while (check.step()) {
  }
  return check.verdict();
}

}  // namespace umov::firmware::boot
