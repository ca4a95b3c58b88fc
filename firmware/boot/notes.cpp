#include "firmware/boot/notes.hpp"

#include "firmware/boot/place_tail.hpp"

namespace umov::firmware::boot {
namespace {

constexpr std::uint32_t words_per_note = 3;
constexpr std::uint32_t told_mark = 0;
static_assert(words_per_note * Notes::capacity < tail_words, "the last word is the installer's");

std::uint32_t word_of(const Flash& flash, std::uint32_t index, std::uint32_t word) {
  return tail_word(flash, Place::staged, words_per_note * index + word);
}

/// The fault's number stands in five bits above the detail, which needs 26.
constexpr unsigned detail_bits = 27;
constexpr std::uint32_t detail_mask = (1u << detail_bits) - 1;
static_assert(static_cast<std::uint32_t>(protocol::Fault::no_fallback) < 1u << (32 - detail_bits));

constexpr std::uint32_t packed(const Note& note) {
  return static_cast<std::uint32_t>(note.fault) << detail_bits |
         (static_cast<std::uint32_t>(note.detail) & detail_mask);
}

}  // namespace

std::optional<Note> Notes::at(std::uint32_t index) const {
  const std::uint32_t word = word_of(*flash_, index, 0);
  if (word_of(*flash_, index, 1) != ~word) return std::nullopt;
  return Note{static_cast<protocol::Fault>(word >> detail_bits),
              static_cast<std::int32_t>(word & detail_mask)};
}

bool Notes::told(std::uint32_t index) const {
  return word_of(*flash_, index, 2) != erased_word;
}

std::uint32_t Notes::first_untold() const {
  std::uint32_t index = 0;
  while (index < capacity && (!at(index) || told(index))) ++index;
  return index;
}

bool Notes::waits(protocol::Fault fault) const {
  for (std::uint32_t index = 0; index < capacity; ++index) {
    const auto note = at(index);
    if (note && note->fault == fault && !told(index)) return true;
  }
  return false;
}

std::optional<Note> Notes::next() const {
  const std::uint32_t index = first_untold();
  return index < capacity ? at(index) : std::nullopt;
}

bool Notes::mark_told() {
  const std::uint32_t index = first_untold();
  return index == capacity ||
         write_tail(*flash_, Place::staged, words_per_note * index + 2, told_mark);
}

bool Notes::leave(const Note& note) {
  if (waits(note.fault)) return true;
  std::uint32_t free = 0;
  for (std::uint32_t index = 0; index < capacity; ++index) {
    const bool blank =
        word_of(*flash_, index, 0) == erased_word && word_of(*flash_, index, 1) == erased_word;
    if (!blank) free = index + 1;
  }
  if (free == capacity) return false;
  const std::uint32_t word = packed(note);
  return write_tail(*flash_, Place::staged, words_per_note * free, word) &&
         write_tail(*flash_, Place::staged, words_per_note * free + 1, ~word);
}

}  // namespace umov::firmware::boot
