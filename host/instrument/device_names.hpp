// What the user may write after --device.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace umov::instrument {

enum class DeviceKind : std::uint8_t { emulator, tcp, usb, hid };

/// A device string taken apart.
struct DeviceName {
  DeviceKind kind = DeviceKind::emulator;
  std::string host;        ///< tcp only
  std::uint16_t port = 0;  ///< tcp only, 1 … 65535
  std::string serial;      ///< usb and hid only; empty: the only one there is
  std::string text;        ///< as the user wrote it
};

/// Takes `emulator`, `usb[:SERIAL]`, `hid[:SERIAL]` or `tcp:HOST:PORT` ([ADDRESS] for IPv6) apart.
/// Throws umov::Error for anything else; `serial:…` is known but not available in this build, and
/// it says so.
DeviceName parse_device_name(std::string_view text);

}  // namespace umov::instrument
