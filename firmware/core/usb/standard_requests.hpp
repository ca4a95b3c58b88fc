// What the program and the boot loader answer alike: how a standard request must look, and
// descriptors from a table.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/core/usb/chapter9.hpp"
#include "firmware/core/usb/control_pipe.hpp"

namespace umov::firmware::usb {

/// Whether the request asks for data; the other standard requests of this stack have no data stage.
constexpr bool asks_standard(std::uint8_t number) {
  return number == standard::get_status || number == standard::get_descriptor ||
         number == standard::get_configuration || number == standard::get_interface;
}

/// Direction and length as they must be for a request that asks for data, or that has none.
constexpr bool proper(const Request& request, bool asks) {
  return asks ? request.to_host : !request.to_host && request.length == 0;
}

/// Serial number of a device as a string descriptor.
class SerialString {
 public:
  /// `text`: ASCII, padded with zeros.
  explicit SerialString(const std::array<char, 24>& text);
  std::span<const std::uint8_t> bytes() const {
    return std::span<const std::uint8_t>(bytes_).first(bytes_[0]);
  }

 private:
  std::array<std::uint8_t, 2 + 2 * 24> bytes_{};
};

/// Index of the string that differs from device to device, iSerialNumber of both.
inline constexpr std::uint8_t serial_index = 3;

/// What a device says of itself, except its serial number.
struct DescriptorTable {
  std::span<const std::uint8_t> device, configuration, bos;
  /// By index, 0: the languages. Empty: there is none of that index.
  std::span<const std::span<const std::uint8_t>> strings;
};

/// The answer to GET_DESCRIPTOR to the device.
ControlAnswer describe(const DescriptorTable& table, const SerialString& serial,
                       const Request& request);

}  // namespace umov::firmware::usb
