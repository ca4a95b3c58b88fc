#include "firmware/boot/installer.hpp"

#include <algorithm>

namespace umov::firmware::boot {
namespace {

constexpr std::array<std::uint8_t, 4> ordered = {'I', 'N', 'S', 'T'};
constexpr std::array<std::uint8_t, 4> carried_out = {0, 0, 0, 0};
constexpr std::uint32_t piece_bytes = 1024;
/// A copy that reads back wrong is made again; then the flash is worn out.
constexpr std::uint32_t most_tries = 3;

std::uint32_t mark_offset(std::span<const std::uint8_t> place) {
  return static_cast<std::uint32_t>(place.size() - Installer::reserved_bytes);
}

}  // namespace

/// Header and program, empty when there is no image. Whether it is good, check_image() tells.
std::span<const std::uint8_t> Installer::image_in(Place place) const {
  const auto all = flash_->contents(place);
  ImageHeader header;
  if (check_header(all, all.size() - reserved_bytes, *trust_, header) != Verdict::good) return {};
  return all.first(header.image_bytes());
}

bool Installer::same(Place a, Place b) const {
  const auto one = image_in(a), other = image_in(b);
  return !one.empty() && std::equal(one.begin(), one.end(), other.begin(), other.end());
}

bool Installer::order() {
  const auto offset = mark_offset(flash_->contents(Place::staged));
  return flash_->program(Place::staged, offset, ordered);
}

bool Installer::begin(bool verified) {
  stage_ = Stage::idle;
  tries_ = 0;
  const auto staged = flash_->contents(Place::staged);
  const auto mark = staged.subspan(mark_offset(staged));
  if (!std::equal(mark.begin(), mark.end(), ordered.begin())) return false;
  if (!verified && check_image(staged, *trust_) != Verdict::good) return false;
  source_ = Place::staged;
  if (same(Place::staged, Place::running)) {
    stage_ = Stage::finish;
  } else if (is_whole(flash_->contents(Place::running), *trust_) &&
             !same(Place::running, Place::previous)) {
    stage_ = Stage::erase_previous;
  } else {
    stage_ = Stage::erase_running;
  }
  return true;
}

bool Installer::begin_restore() {
  tries_ = 0;
  if (check_image(flash_->contents(Place::previous), *trust_) != Verdict::good) return false;
  source_ = Place::previous;
  stage_ = Stage::erase_running;
  return true;
}

void Installer::copy_piece(Place to, Stage next) {
  const Place from = to == Place::previous ? Place::running : source_;
  const auto image = image_in(from);
  const auto rest = image.subspan(std::min<std::size_t>(copied_, image.size()));
  const auto piece = rest.first(std::min<std::size_t>(rest.size(), piece_bytes));
  if (!piece.empty() && !flash_->program(to, copied_, piece)) {
    stage_ = ++tries_ < most_tries
                 ? (to == Place::previous ? Stage::erase_previous : Stage::erase_running)
                 : Stage::failed;
    return;
  }
  copied_ += static_cast<std::uint32_t>(piece.size());
  if (copied_ >= image.size()) stage_ = next;
}

bool Installer::step() {
  switch (stage_) {
    case Stage::idle:
    case Stage::failed:
      return false;
    case Stage::erase_previous:
    case Stage::erase_running: {
      const bool running = stage_ == Stage::erase_running;
      copied_ = 0;
      stage_ = !flash_->erase(running ? Place::running : Place::previous) ? Stage::failed
               : running                                                  ? Stage::copy
                                                                          : Stage::keep;
      break;
    }
    case Stage::keep:
      copy_piece(Place::previous, Stage::erase_running);
      break;
    case Stage::copy:
      copy_piece(Place::running, Stage::finish);
      break;
    case Stage::finish:
      if (source_ == Place::staged) {
        const auto offset = mark_offset(flash_->contents(Place::staged));
        if (!flash_->program(Place::staged, offset, carried_out)) {
          stage_ = Stage::failed;
          break;
        }
      }
      stage_ = Stage::idle;
      break;
  }
  return stage_ != Stage::idle && stage_ != Stage::failed;
}

}  // namespace umov::firmware::boot
