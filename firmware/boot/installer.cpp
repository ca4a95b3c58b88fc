#include "firmware/boot/installer.hpp"

#include <algorithm>

#include "firmware/boot/notes.hpp"

namespace umov::firmware::boot {
namespace {

constexpr std::uint32_t order_word = tail_words - 1;
constexpr std::uint32_t order_mark = 0x5453'4E49;  // "INST"
constexpr std::uint32_t carried_out = 0;
constexpr std::uint32_t piece_bytes = 1024;
/// A copy that reads back wrong is made again; then the flash is worn out.
constexpr std::uint32_t most_tries = 3;

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

bool Installer::ordered() const {
  return tail_word(*flash_, Place::staged, order_word) == order_mark;
}

bool Installer::order() {
  return write_tail(*flash_, Place::staged, order_word, order_mark);
}

bool Installer::spoil(Place place) {
  constexpr std::array<std::uint8_t, 4> nothing{};
  return flash_->program(place, 0, nothing);
}

bool Installer::begin(bool verified) {
  stage_ = Stage::idle;
  tries_ = 0;
  kept_ = true;
  if (!ordered()) return false;
  if (!verified && check_image(flash_->contents(Place::staged), *trust_) != Verdict::good) {
    return false;
  }
  source_ = Place::staged;
  const bool another_trial = verified && trial_.open() && trial_.failures() > 0;
  if (same(Place::staged, Place::running) && !another_trial) {
    stage_ = Stage::finish;
  } else if (is_whole(flash_->contents(Place::running), *trust_) && !trial_.open() &&
             !same(Place::running, Place::previous)) {
    stage_ = Stage::erase_previous;
  } else {
    // An erasure cut short may clear the trial's mark and leave the image: what has not proved
    // itself would then count as proven.
    stage_ = trial_.open() ? Stage::spoil_running : Stage::erase_running;
  }
  return true;
}

bool Installer::begin_restore() {
  tries_ = 0;
  if (check_image(flash_->contents(Place::previous), *trust_) != Verdict::good) return false;
  if (ordered() && !spoil(Place::staged)) return false;
  source_ = Place::previous;
  stage_ = Stage::spoil_running;
  return true;
}

/// What was written to that place reads back wrong, or could not be erased.
void Installer::try_again(Place to) {
  const bool again = ++tries_ < most_tries;
  if (to == Place::running) {
    stage_ = again ? Stage::erase_running : Stage::failed;
    return;
  }
  stage_ = again ? Stage::erase_previous : Stage::erase_running;
  if (again) return;
  tries_ = 0;
  kept_ = false;
  const bool older = check_image(flash_->contents(Place::previous), *trust_) == Verdict::good;
  Notes(*flash_).leave({protocol::Fault::no_fallback,
                        older ? protocol::only_an_older_one : protocol::none_to_fall_back_to});
}

void Installer::erase_for(Stage next) {
  const Place place = next == Stage::keep ? Place::previous : Place::running;
  copied_ = 0;
  const bool tried_out = place == Place::running && source_ == Place::staged;
  if (!flash_->erase(place) || (tried_out && !trial_.begin())) return try_again(place);
  stage_ = next;
}

void Installer::copy_piece(Place to, Stage next) {
  const Place from = to == Place::previous ? Place::running : source_;
  const auto image = image_in(from);
  const auto rest = image.subspan(std::min<std::size_t>(copied_, image.size()));
  const auto piece = rest.first(std::min<std::size_t>(rest.size(), piece_bytes));
  if (!piece.empty() && !flash_->program(to, copied_, piece)) return try_again(to);
  copied_ += static_cast<std::uint32_t>(piece.size());
  if (copied_ >= image.size()) stage_ = next;
}

void Installer::finish() {
  const bool done =
      source_ != Place::staged || write_tail(*flash_, Place::staged, order_word, carried_out);
  stage_ = done ? Stage::idle : Stage::failed;
}

bool Installer::step() {
  switch (stage_) {
    case Stage::idle:
    case Stage::failed:
      return false;
    case Stage::erase_previous:
      erase_for(Stage::keep);
      break;
    case Stage::keep:
      copy_piece(Place::previous, Stage::erase_running);
      break;
    case Stage::spoil_running:
      // Where that fails the erasure says so.
      spoil(Place::running);
      stage_ = Stage::erase_running;
      break;
    case Stage::erase_running:
      erase_for(Stage::copy);
      break;
    case Stage::copy:
      copy_piece(Place::running, Stage::finish);
      break;
    case Stage::finish:
      finish();
      break;
  }
  return stage_ != Stage::idle && stage_ != Stage::failed;
}

}  // namespace umov::firmware::boot
