// The two flash sectors of the saved settings.
#pragma once

#include "boards/stm32f407/flash_memory.hpp"
#include "boards/stm32f407/watchdog.hpp"
#include "firmware/core/config/settings_pages.hpp"

namespace umov::boards::stm32f407 {

/// Programming a set takes 0.7 ms (16 us a word, typical), in which the processor stands still;
/// erasing a quarter of a second, at most half of one (DS8626, table 47).
class SettingsFlash final : public firmware::FlashPages {
 public:
  std::uint32_t words_per_page() const override { return settings_area_a.size / 4; }
  std::uint32_t read(int page, std::uint32_t word) const override {
    return *reinterpret_cast<const volatile std::uint32_t*>(area(page).address + 4 * word);
  }
  bool program(int page, std::uint32_t word, std::span<const std::uint32_t> words) override {
    return stm32f407::program(area(page).address + 4 * word, words);
  }
  bool erase(int page) override {
    const LongWork may_take_long;
    return stm32f407::erase(area(page));
  }

 private:
  static const FlashArea& area(int page) { return page == 0 ? settings_area_a : settings_area_b; }
};
static_assert(settings_area_a.size == settings_area_b.size);

}  // namespace umov::boards::stm32f407
