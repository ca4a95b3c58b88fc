// The three places of images in this chip's flash.
#pragma once

#include <algorithm>
#include <array>
#include <cstring>

#include "boards/stm32f407/flash_memory.hpp"
#include "firmware/boot/port.hpp"

namespace umov::boards::stm32f407 {

class BootFlash final : public firmware::boot::Flash {
 public:
  std::span<const std::uint8_t> contents(firmware::boot::Place place) const override {
    const FlashArea& a = area(place);
    return {reinterpret_cast<const std::uint8_t*>(a.address), a.size};
  }
  bool erase(firmware::boot::Place place) override { return stm32f407::erase(area(place)); }
  bool program(firmware::boot::Place place, std::uint32_t offset,
               std::span<const std::uint8_t> bytes) override {
    std::array<std::uint32_t, 64> words;
    while (!bytes.empty()) {
      const std::size_t size = std::min(bytes.size(), sizeof(words));
      std::memcpy(words.data(), bytes.data(), size);
      if (!stm32f407::program(area(place).address + offset, std::span(words).first(size / 4))) {
        return false;
      }
      bytes = bytes.subspan(size);
      offset += static_cast<std::uint32_t>(size);
    }
    return true;
  }

 private:
  static const FlashArea& area(firmware::boot::Place place) {
    switch (place) {
      case firmware::boot::Place::staged:
        return staged_area;
      case firmware::boot::Place::previous:
        return previous_area;
      case firmware::boot::Place::running:
        break;
    }
    return image_area;
  }
};
static_assert(staged_area.size == image_area.size && previous_area.size == image_area.size);

}  // namespace umov::boards::stm32f407
