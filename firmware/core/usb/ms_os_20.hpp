// Microsoft OS 2.0 descriptors: Windows 8.1 and later then uses WinUSB for the bulk and DFU
// interfaces without a driver to install. Source: "Microsoft OS 2.0 Descriptors Specification".
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "firmware/core/usb/descriptor_builder.hpp"

namespace umov::firmware::usb::ms_os_20 {

/// bRequest of the vendor request that reads the set; our own choice, told in the BOS descriptor.
inline constexpr std::uint8_t vendor_code = 0x01;
/// wIndex of that request, MS_OS_20_DESCRIPTOR_INDEX.
inline constexpr std::uint16_t descriptor_index = 7;
/// Windows 8.1, the first that knows these descriptors.
inline constexpr Bytes<4> windows_version = {0x00, 0x00, 0x03, 0x06};

enum class Type : std::uint8_t {
  set_header = 0,
  configuration_subset = 1,
  function_subset = 2,
  compatible_id = 3,
  registry_property = 4,
};

constexpr Bytes<4> head(std::size_t length, Type type) {
  return {low_byte(length), high_byte(length), static_cast<std::uint8_t>(type), 0};
}

/// "Use WinUSB for this function."
inline constexpr Bytes<20> winusb =
    join(head(20, Type::compatible_id), Bytes<6>{'W', 'I', 'N', 'U', 'S', 'B'}, Bytes<10>{});

/// UTF-16 of an ASCII literal, its final zero included.
template <std::size_t N>
constexpr Bytes<2 * N> wide(const char (&text)[N]) {
  Bytes<2 * N> bytes{};
  for (std::size_t i = 0; i < N; ++i) bytes[2 * i] = static_cast<std::uint8_t>(text[i]);
  return bytes;
}

/// Registry value DeviceInterfaceGUIDs (REG_MULTI_SZ), by which programs find the interface.
template <std::size_t N>
constexpr auto interface_guid(const char (&guid)[N]) {
  constexpr std::uint8_t multi_string = 7;
  constexpr auto name = wide("DeviceInterfaceGUIDs");
  const auto value = join(wide(guid), Bytes<2>{});
  constexpr std::size_t length = 10 + name.size() + 2 * N + 2;
  return join(head(length, Type::registry_property), Bytes<2>{multi_string, 0},
              Bytes<2>{low_byte(name.size()), high_byte(name.size())}, name,
              Bytes<2>{low_byte(value.size()), high_byte(value.size())}, value);
}

/// What is said of the function that begins with `interface`.
template <std::size_t N>
constexpr Bytes<N + 8> function(std::uint8_t interface, const Bytes<N>& features) {
  return join(head(8, Type::function_subset), Bytes<2>{interface, 0},
              Bytes<2>{low_byte(N + 8), high_byte(N + 8)}, features);
}

/// The whole set, for the first configuration.
template <std::size_t N>
constexpr Bytes<N + 18> descriptor_set(const Bytes<N>& functions) {
  return join(head(10, Type::set_header), windows_version,
              Bytes<2>{low_byte(N + 18), high_byte(N + 18)}, head(8, Type::configuration_subset),
              Bytes<2>{0, 0}, Bytes<2>{low_byte(N + 8), high_byte(N + 8)}, functions);
}

/// The platform capability in the BOS descriptor that announces a set of `set_size` bytes.
constexpr Bytes<28> platform_capability(std::size_t set_size) {
  // D8DD60DF-4589-4CC7-9CD2-659D9E648A9F, MS OS 2.0 platform capability.
  constexpr Bytes<16> uuid = {0xdf, 0x60, 0xdd, 0xd8, 0x89, 0x45, 0xc7, 0x4c,
                              0x9c, 0xd2, 0x65, 0x9d, 0x9e, 0x64, 0x8a, 0x9f};
  constexpr std::uint8_t platform = 5;
  return join(
      Bytes<4>{28, static_cast<std::uint8_t>(DescriptorType::device_capability), platform, 0}, uuid,
      windows_version, Bytes<4>{low_byte(set_size), high_byte(set_size), vendor_code, 0});
}

}  // namespace umov::firmware::usb::ms_os_20
