// What is kept over restarts: the settings of all axes, modulation and detection, as the bytes of
// the messages that set them.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "protocol/codec.hpp"
#include "protocol/messages.hpp"

namespace umov::firmware {

struct SavedSettings {
  std::array<protocol::SetAxis, protocol::axis_count> axes{};
  protocol::SetLockin lockin{};
};

/// To be counted up whenever the bytes below get another meaning.
inline constexpr std::uint16_t settings_layout = 2;
inline constexpr std::size_t settings_bytes =
    protocol::axis_count * protocol::wire_size<protocol::SetAxis> +
    protocol::wire_size<protocol::SetLockin>;
static_assert(settings_bytes == 163, "other settings need another settings_layout");

using SettingsBytes = std::array<std::uint8_t, settings_bytes>;

inline SettingsBytes settings_to_bytes(const SavedSettings& settings) {
  SettingsBytes bytes{};
  std::span<std::uint8_t> rest(bytes);
  for (const auto& axis : settings.axes) {
    (void)protocol::encode(axis, rest);
    rest = rest.subspan(protocol::wire_size<protocol::SetAxis>);
  }
  (void)protocol::encode(settings.lockin, rest);
  return bytes;
}

/// False when a field is outside the range of its message, or an axis is not in its place.
inline bool settings_from_bytes(const SettingsBytes& bytes, SavedSettings& settings) {
  constexpr std::size_t axis_bytes = protocol::wire_size<protocol::SetAxis>;
  std::span<const std::uint8_t> rest(bytes);
  for (std::size_t i = 0; i < settings.axes.size(); ++i) {
    if (!protocol::decode(rest.first(axis_bytes), settings.axes[i]).ok()) return false;
    if (settings.axes[i].axis != i) return false;
    rest = rest.subspan(axis_bytes);
  }
  return protocol::decode(rest, settings.lockin).ok();
}

}  // namespace umov::firmware
