// The saved settings of the native board: RAM that outlives the board when the caller keeps it.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "firmware/core/port.hpp"

namespace umov::boards::native {

class RamSettings final : public firmware::SettingsStore {
 public:
  Loaded load(std::uint16_t layout, std::span<std::uint8_t> settings) const override {
    if (saved_.empty()) return Loaded::none;
    if (layout_ != layout || saved_.size() != settings.size()) return Loaded::other_layout;
    std::copy(saved_.begin(), saved_.end(), settings.begin());
    return Loaded::good;
  }
  bool save(std::uint16_t layout, std::span<const std::uint8_t> settings) override {
    if (refuses) return false;
    layout_ = layout;
    saved_.assign(settings.begin(), settings.end());
    return true;
  }
  bool next_save_is_slow() const override { return false; }

  /// Stores nothing more, as flash without room.
  bool refuses = false;

 private:
  std::uint16_t layout_ = 0;
  std::vector<std::uint8_t> saved_;
};

}  // namespace umov::boards::native
