// Descriptors as arrays of bytes, put together and checked while compiling.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/core/usb/chapter9.hpp"
#include "firmware/core/usb/port.hpp"

namespace umov::firmware::usb {

template <std::size_t N>
using Bytes = std::array<std::uint8_t, N>;

constexpr std::uint8_t low_byte(std::size_t value) {
  return static_cast<std::uint8_t>(value & 0xffu);
}
constexpr std::uint8_t high_byte(std::size_t value) {
  return static_cast<std::uint8_t>((value >> 8) & 0xffu);
}

/// One array after the other.
template <std::size_t... N>
constexpr Bytes<(N + ... + 0)> join(const Bytes<N>&... parts) {
  Bytes<(N + ... + 0)> all{};
  std::size_t at = 0;
  const auto append = [&](const auto& part) {
    for (const std::uint8_t byte : part) all[at++] = byte;
  };
  (append(parts), ...);
  return all;
}

/// String descriptor of an ASCII literal, UTF-16.
template <std::size_t N>
constexpr Bytes<2 * N> string_descriptor(const char (&text)[N]) {
  static_assert(2 * N <= 255);
  Bytes<2 * N> bytes{};
  bytes[0] = low_byte(2 * N);
  bytes[1] = static_cast<std::uint8_t>(DescriptorType::string);
  for (std::size_t i = 0; i + 1 < N; ++i) bytes[2 + 2 * i] = static_cast<std::uint8_t>(text[i]);
  return bytes;
}

struct InterfaceClass {
  std::uint8_t code;
  std::uint8_t subclass;
  std::uint8_t protocol;
};

constexpr Bytes<9> interface_descriptor(std::uint8_t number, std::uint8_t endpoints,
                                        InterfaceClass kind, std::uint8_t name_string) {
  return {9,
          static_cast<std::uint8_t>(DescriptorType::interface),
          number,
          0,
          endpoints,
          kind.code,
          kind.subclass,
          kind.protocol,
          name_string};
}

constexpr Bytes<7> endpoint_descriptor(EndpointAddress address, EndpointType type,
                                       std::uint16_t max_packet, std::uint8_t interval_ms) {
  return {7,
          static_cast<std::uint8_t>(DescriptorType::endpoint),
          address,
          static_cast<std::uint8_t>(type),
          low_byte(max_packet),
          high_byte(max_packet),
          interval_ms};
}

/// HID 1.11 section 6.2.1; no country code.
constexpr Bytes<9> hid_descriptor(std::size_t report_descriptor_size) {
  return {9,
          static_cast<std::uint8_t>(DescriptorType::hid),
          0x11,
          0x01,
          0,
          1,
          static_cast<std::uint8_t>(DescriptorType::hid_report),
          low_byte(report_descriptor_size),
          high_byte(report_descriptor_size)};
}

/// DFU 1.1 section 4.1.3.
constexpr Bytes<9> dfu_functional(std::uint8_t attributes, std::uint16_t detach_timeout_ms,
                                  std::uint16_t transfer_bytes) {
  return {9,
          dfu_functional_descriptor,
          attributes,
          low_byte(detach_timeout_ms),
          high_byte(detach_timeout_ms),
          low_byte(transfer_bytes),
          high_byte(transfer_bytes),
          0x10,
          0x01};
}

/// Puts the configuration descriptor before its interfaces and counts them.
/// `attributes`: bit 7 is set always, bit 6 means self-powered.
template <std::size_t N>
constexpr Bytes<N + 9> configuration_descriptor(const Bytes<N>& interfaces, std::uint8_t attributes,
                                                std::uint16_t current_ma) {
  std::uint8_t count = 0;
  for (std::size_t at = 0; at + 1 < N && interfaces[at] != 0; at += interfaces[at]) {
    if (interfaces[at + 1] == static_cast<std::uint8_t>(DescriptorType::interface)) ++count;
  }
  const Bytes<9> head = {9,
                         static_cast<std::uint8_t>(DescriptorType::configuration),
                         low_byte(N + 9),
                         high_byte(N + 9),
                         count,
                         1,
                         0,
                         static_cast<std::uint8_t>(attributes | 0x80u),
                         static_cast<std::uint8_t>(current_ma / 2)};
  return join(head, interfaces);
}

/// Whether a configuration descriptor holds together: lengths fit one another, interfaces are
/// numbered from 0 and have the endpoints they promise, no endpoint address occurs twice, packet
/// sizes are those of full speed, and endpoint numbers are at most `most_endpoints`.
constexpr bool well_formed_configuration(std::span<const std::uint8_t> bytes,
                                         std::uint8_t most_endpoints) {
  if (bytes.size() < 9 || bytes[0] != 9 ||
      bytes[1] != static_cast<std::uint8_t>(DescriptorType::configuration) ||
      static_cast<std::size_t>(bytes[2] | (bytes[3] << 8)) != bytes.size()) {
    return false;
  }
  std::uint32_t seen = 0;  // bit n: OUT n, bit 16 + n: IN n
  std::uint8_t interfaces = 0;
  std::uint8_t endpoints_due = 0;
  for (std::size_t at = 9; at < bytes.size();) {
    const std::size_t size = bytes[at];
    if (size < 2 || at + size > bytes.size()) return false;
    const std::uint8_t type = bytes[at + 1];
    if (type == static_cast<std::uint8_t>(DescriptorType::interface)) {
      if (size != 9 || endpoints_due != 0 || bytes[at + 2] != interfaces) return false;
      ++interfaces;
      endpoints_due = bytes[at + 4];
    } else if (type == static_cast<std::uint8_t>(DescriptorType::endpoint)) {
      if (size != 7 || endpoints_due == 0) return false;
      --endpoints_due;
      const std::uint8_t number = endpoint_number(bytes[at + 2]);
      const std::uint32_t bit = 1u << (number + (is_in(bytes[at + 2]) ? 16 : 0));
      const auto packet = static_cast<std::size_t>(bytes[at + 4] | (bytes[at + 5] << 8));
      const bool bulk = bytes[at + 3] == static_cast<std::uint8_t>(EndpointType::bulk);
      const bool interrupt = bytes[at + 3] == static_cast<std::uint8_t>(EndpointType::interrupt);
      const bool size_good = bulk ? packet == 8 || packet == 16 || packet == 32 || packet == 64
                             : interrupt ? packet >= 1 && packet <= max_packet_bytes
                                         : false;
      if (number == 0 || number > most_endpoints || (seen & bit) != 0 || !size_good) return false;
      if (interrupt && bytes[at + 6] == 0) return false;
      seen |= bit;
    } else if (interfaces == 0) {
      return false;  // a class descriptor belongs to an interface
    }
    at += size;
  }
  return endpoints_due == 0 && interfaces == bytes[4] && interfaces > 0;
}

}  // namespace umov::firmware::usb
