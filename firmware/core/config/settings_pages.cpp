#include "firmware/core/config/settings_pages.hpp"

#include "protocol/crc32c.hpp"

namespace umov::firmware {
namespace {

constexpr std::uint32_t erased = 0xFFFF'FFFF;
constexpr std::uint32_t complete_mark = 0x4556'4153;  // "SAVE"
constexpr std::uint32_t crc_word = SettingsPages::slot_words - 2;
constexpr std::uint32_t mark_word = SettingsPages::slot_words - 1;

std::array<std::uint8_t, 4> bytes_of(std::uint32_t word) {
  return {static_cast<std::uint8_t>(word), static_cast<std::uint8_t>(word >> 8),
          static_cast<std::uint8_t>(word >> 16), static_cast<std::uint8_t>(word >> 24)};
}

}  // namespace

SettingsPages::Slot SettingsPages::kind_of(Place at) const {
  bool blank = true;
  std::uint32_t crc = 0;
  for (std::uint32_t i = 0; i < slot_words; ++i) {
    const std::uint32_t value = word(at, i);
    blank = blank && value == erased;
    if (i < crc_word) crc = protocol::crc32c(bytes_of(value), crc);
  }
  if (blank) return Slot::blank;
  if (word(at, mark_word) != complete_mark) return Slot::cut_short;
  return word(at, crc_word) == crc ? Slot::complete : Slot::damaged;
}

SettingsPages::Page SettingsPages::look_at(int page) const {
  Page found;
  for (std::uint32_t slot = 0; slot < slots(); ++slot) {
    const Place at{page, slot};
    const Slot kind = kind_of(at);
    if (kind == Slot::blank) continue;
    found.used = slot + 1;
    if (kind == Slot::damaged) found.damaged_after = true;
    if (kind != Slot::complete) continue;
    found.newest = at;
    found.sequence = word(at, 1);
    found.damaged_after = false;
  }
  return found;
}

void SettingsPages::begin() {
  const std::array<Page, 2> pages = {look_at(0), look_at(1)};
  const auto has = [&](int page) { return pages[static_cast<std::size_t>(page)].newest.page >= 0; };
  for (std::size_t page = 0; page < 2; ++page) used_[page] = pages[page].used;
  if (!has(0) && !has(1)) {
    newest_ = {};
    sequence_ = 0;
    damaged_ = pages[0].damaged_after || pages[1].damaged_after;
    // Something else stood in this flash before: without room nothing could ever be saved.
    if (used_[0] == slots() && used_[1] == slots() && flash_->erase(0)) used_[0] = 0;
    return;
  }
  const bool second = has(1) && (!has(0) || pages[1].sequence > pages[0].sequence);
  const Page& active = pages[second ? 1 : 0];
  const int other = second ? 0 : 1;
  const Page& rest = pages[static_cast<std::size_t>(other)];
  newest_ = active.newest;
  sequence_ = active.sequence;
  // A page is filled to its end only when the other one is blank: what stands there then is newer.
  const bool rest_is_newer = active.used == slots() && !has(other);
  damaged_ = active.damaged_after || (rest_is_newer && rest.damaged_after);
  if (rest.used > 0 && !rest_is_newer && flash_->erase(other)) {
    used_[static_cast<std::size_t>(other)] = 0;
  }
}

SettingsStore::Loaded SettingsPages::load(std::uint16_t layout,
                                          std::span<std::uint8_t> settings) const {
  if (damaged_) return Loaded::damaged;
  if (newest_.page < 0) return Loaded::none;
  const std::uint32_t head = word(newest_, 0);
  if (head != (std::uint32_t{layout} << 16 | settings.size())) return Loaded::other_layout;
  for (std::size_t i = 0; i < settings.size(); ++i) {
    settings[i] = bytes_of(word(newest_, 2 + static_cast<std::uint32_t>(i / 4)))[i % 4];
  }
  return Loaded::good;
}

/// The last slot is taken when the other page is blank only: see begin(). A power cut during the
/// erasure leaves a page with a free slot beside one that is not blank, which is then erased.
bool SettingsPages::next_save_is_slow() const {
  const auto page = static_cast<std::size_t>(page_in_use());
  return used_[page] + 1 == slots() && used_[1 - page] > 0;
}

bool SettingsPages::choose_place(Place& next) {
  const int page = page_in_use(), other = 1 - page;
  const std::uint32_t used = used_[static_cast<std::size_t>(page)];
  std::uint32_t& elsewhere = used_[static_cast<std::size_t>(other)];
  if (next_save_is_slow()) {
    if (!flash_->erase(other)) return false;
    elsewhere = 0;
  }
  if (used < slots()) {
    next = {page, used};
    return true;
  }
  if (elsewhere >= slots()) return false;
  next = {other, elsewhere};
  return true;
}

bool SettingsPages::save(std::uint16_t layout, std::span<const std::uint8_t> settings) {
  if (settings.size() > capacity_bytes) return false;
  std::array<std::uint32_t, slot_words> words{};
  words[0] = std::uint32_t{layout} << 16 | static_cast<std::uint32_t>(settings.size());
  words[1] = sequence_ + 1;
  for (std::size_t i = 0; i < settings.size(); ++i) {
    words[2 + i / 4] |= static_cast<std::uint32_t>(settings[i]) << (8 * (i % 4));
  }
  std::uint32_t crc = 0;
  for (std::uint32_t i = 0; i < crc_word; ++i) crc = protocol::crc32c(bytes_of(words[i]), crc);
  words[crc_word] = crc;
  words[mark_word] = complete_mark;

  Place next;
  if (!choose_place(next)) return false;
  // Also after an error the slot is used up: what stands there is passed over.
  used_[static_cast<std::size_t>(next.page)] = next.slot + 1;
  const std::uint32_t at = next.slot * slot_words;
  const std::span<const std::uint32_t> all(words);
  if (!flash_->program(next.page, at, all.first(mark_word)) ||
      !flash_->program(next.page, at + mark_word, all.last(1))) {
    return false;
  }
  newest_ = next;
  ++sequence_;
  damaged_ = false;
  return true;
}

}  // namespace umov::firmware
