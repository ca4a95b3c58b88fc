// What the user may write after --device.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace umov::instrument {

enum class DeviceKind : std::uint8_t { emulator, tcp, usb, hid, serial };

/// A device string taken apart.
struct DeviceName {
  DeviceKind kind = DeviceKind::emulator;
  std::string host;                ///< tcp only
  std::uint16_t port = 0;          ///< tcp only, 1 … 65535
  std::string serial;              ///< usb and hid only; empty: the only one there is
  std::string text;                ///< as the user wrote it
  std::string path{};              ///< serial only, such as /dev/ttyUSB0
  std::uint32_t baud = 1'000'000;  ///< serial only
};

/// Takes `emulator`, `usb[:SERIAL]`, `hid[:SERIAL]`, `serial:PATH[?baud=N]` or `tcp:HOST:PORT`
/// ([ADDRESS] for IPv6) apart. Throws umov::Error for anything else.
DeviceName parse_device_name(std::string_view text);

}  // namespace umov::instrument
