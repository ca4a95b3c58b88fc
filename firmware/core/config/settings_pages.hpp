// Saved settings in two pages of flash: a new set is written beside the old one, so that a power
// cut at any word leaves the one or the other.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/core/port.hpp"

namespace umov::firmware {

/// Two pages of flash, 0 and 1, of equal size: erased to ones, programmed by words, once each.
class FlashPages {
 public:
  virtual std::uint32_t words_per_page() const = 0;
  virtual std::uint32_t read(int page, std::uint32_t word) const = 0;
  /// False when the flash reports an error or reads back something else.
  virtual bool program(int page, std::uint32_t word, std::span<const std::uint32_t> words) = 0;
  virtual bool erase(int page) = 0;

 protected:
  FlashPages() = default;
  FlashPages(const FlashPages&) = default;
  FlashPages& operator=(const FlashPages&) = default;
  ~FlashPages() = default;
};

/// A page is a row of slots, filled one after the other. A slot holds
///
///   word 0      layout of the settings (upper half), bytes of them (lower half)
///   word 1      number of the saving, counted up
///   from 2 on   the settings, zeros after the last byte
///   last but 1  CRC-32C of the words before
///   last        "SAVE", written when all else stands
///
/// The newest complete slot counts. One without its last word was cut short and is passed over; one
/// that has it and fails its CRC has been damaged afterwards. When a page is full the next slot is
/// the first of the other page. The full page is erased at the next start, or by the saving that
/// finds one slot left in the page in use: then nothing but older settings stand there.
/// Contexts: main loop.
class SettingsPages final : public SettingsStore {
 public:
  explicit SettingsPages(FlashPages& flash) : flash_(&flash) {}

  /// Once, before anything moves: finds the newest slot and makes room. Erases at most one page.
  void begin();

  Loaded load(std::uint16_t layout, std::span<std::uint8_t> settings) const override;
  /// False when the flash fails. One saving in 64 erases a page first: nothing may move then.
  bool save(std::uint16_t layout, std::span<const std::uint8_t> settings) override;
  bool next_save_is_slow() const override;

  static constexpr std::uint32_t slot_words = 64;
  /// Settings may be so long.
  static constexpr std::size_t capacity_bytes = 4 * (slot_words - 4);

 private:
  enum class Slot : std::uint8_t { blank, cut_short, damaged, complete };
  struct Place {
    int page = -1;  ///< -1: none
    std::uint32_t slot = 0;
  };
  struct Page {
    Place newest{};
    std::uint32_t sequence = 0;
    std::uint32_t used = 0;  ///< slots up to the last that is not blank
    bool damaged_after = false;
  };

  std::uint32_t slots() const { return flash_->words_per_page() / slot_words; }
  std::uint32_t word(Place at, std::uint32_t i) const {
    return flash_->read(at.page, at.slot * slot_words + i);
  }
  int page_in_use() const { return newest_.page >= 0 ? newest_.page : used_[0] < slots() ? 0 : 1; }
  Slot kind_of(Place at) const;
  Page look_at(int page) const;
  bool choose_place(Place& next);

  FlashPages* flash_;
  Place newest_{};
  bool damaged_ = false;
  std::uint32_t sequence_ = 0;
  std::array<std::uint32_t, 2> used_{};
};

}  // namespace umov::firmware
