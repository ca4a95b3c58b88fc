#include "boards/stm32f407/flash_log.hpp"

#include <algorithm>

#include "firmware/boot/place_tail.hpp"
#include "protocol/crc32c.hpp"

namespace umov::boards::stm32f407 {
namespace {

constexpr std::size_t entry_words = 6;
constexpr std::uint32_t entry_bytes = 4 * entry_words;
constexpr std::uint32_t end_of_entries = log_area.size / entry_bytes * entry_bytes;
constexpr std::uint32_t full_from = end_of_entries / 8 * 7;
constexpr std::uint32_t erased = 0xFFFF'FFFF;

/// In the upper half of word 0, above the fault's number.
constexpr std::uint32_t fault_kind = 0x4641, start_kind = 0x5354;

using Words = std::array<std::uint32_t, entry_words>;

std::uint32_t crc_of(const Words& words) {
  std::array<std::uint8_t, entry_bytes - 4> bytes;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    bytes[i] = static_cast<std::uint8_t>(words[i / 4] >> (8 * (i % 4)));
  }
  return protocol::crc32c(bytes);
}

Words words_at(std::uint32_t offset) {
  const auto* place = reinterpret_cast<const volatile std::uint32_t*>(log_area.address + offset);
  Words words;
  for (std::size_t i = 0; i < entry_words; ++i) words[i] = place[i];
  return words;
}

/// Numbers of starts that wait out the erasure of the log: pairs of a number and its complement in
/// the part of the image's sector that no image may take. A new image erases them; the log has the
/// number then.
struct Refuge {
  static constexpr std::uint32_t longest_image = 96 * 1024, pair_bytes = 8;
  static constexpr std::uintptr_t begin = image_area.address + longest_image,
                                  end = image_area.address + image_area.size -
                                        firmware::boot::reserved_bytes;

  Refuge() {
    for (; free < end; free += pair_bytes) {
      const auto* pair = reinterpret_cast<const volatile std::uint32_t*>(free);
      const std::uint32_t number = pair[0], complement = pair[1];
      if (number == erased && complement == erased) return;
      if (complement == ~number) newest = std::max(newest, number);
    }
  }
  /// False when there is no room or the flash fails.
  bool keep(std::uint32_t number) const {
    return free < end && program(free, std::array{number, ~number});
  }

  std::uint32_t newest = 0;
  std::uintptr_t free = begin;
};

}  // namespace

std::uint32_t FlashLog::begin() {
  std::uint32_t starts = 0;
  for (used_ = 0; used_ < end_of_entries; used_ += entry_bytes) {
    const Words words = words_at(used_);
    if (std::all_of(words.begin(), words.end(), [](std::uint32_t w) { return w == erased; })) break;
    if (words[entry_words - 1] != crc_of(words)) continue;
    // Every entry carries the start it belongs to: the count outlives a lost start entry.
    starts = std::max(starts, words[1]);
    if (words[0] >> 16 == fault_kind) {
      keep({.time_us = words[2] | std::uint64_t{words[3]} << 32,
            .boot_id = words[1],
            .fault = static_cast<std::uint8_t>(words[0]),
            .detail = static_cast<std::int32_t>(words[4])});
    }
  }
  const std::uint32_t number = std::max(starts, Refuge().newest) + 1;
  if (used_ <= full_from || !make_room(number)) write(start_kind, {.boot_id = number});
  return number;
}

bool FlashLog::make_room(std::uint32_t number) {
  // Without the number in safety a power cut from here on would begin at 1 again.
  if (!Refuge().keep(number) || !erase(log_area)) return false;
  used_ = 0;
  unwritten_ = count_;
  write(start_kind, {.boot_id = number});
  service();
  return true;
}

void FlashLog::keep(const firmware::LoggedFault& entry) {
  newest_[(first_ + count_) % capacity] = entry;
  if (count_ < capacity) {
    ++count_;
  } else {
    first_ = static_cast<std::uint16_t>((first_ + 1) % capacity);
  }
}

void FlashLog::append(const firmware::LoggedFault& entry) {
  keep(entry);
  if (unwritten_ < count_) ++unwritten_;
}

bool FlashLog::read(std::uint16_t index, firmware::LoggedFault& entry) const {
  if (index >= count_) return false;
  entry = newest_[(first_ + count_ - 1u - index) % capacity];
  return true;
}

void FlashLog::service() {
  while (unwritten_ > 0 && used_ + entry_bytes <= end_of_entries) {
    if (!write(fault_kind, newest_[(first_ + count_ - unwritten_) % capacity])) return;
    --unwritten_;
  }
}

bool FlashLog::write(std::uint32_t kind, const firmware::LoggedFault& entry) {
  if (used_ + entry_bytes > end_of_entries) return false;
  Words words = {kind << 16 | entry.fault,
                 entry.boot_id,
                 static_cast<std::uint32_t>(entry.time_us),
                 static_cast<std::uint32_t>(entry.time_us >> 32),
                 static_cast<std::uint32_t>(entry.detail),
                 0};
  words[entry_words - 1] = crc_of(words);
  const std::uint32_t place = used_;
  used_ += entry_bytes;  // also after an error: a place half written is passed over
  return program(log_area.address + place, words);
}

}  // namespace umov::boards::stm32f407
