// A control transfer as the virtual bus takes it.
#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "hil/usbip/bus.hpp"

namespace umov::test {

/// The fields of a SETUP packet in the order of USB 2.0, table 9-2: bmRequestType, bRequest,
/// wValue, wIndex, wLength.
struct SetupFields {
  std::uint8_t type;
  std::uint8_t request;
  std::uint16_t value;
  std::uint16_t index;
  std::uint16_t length;

  bool to_host() const { return (type & 0x80) != 0; }
  std::array<std::uint8_t, 8> bytes() const {
    return {type,
            request,
            static_cast<std::uint8_t>(value),
            static_cast<std::uint8_t>(value >> 8),
            static_cast<std::uint8_t>(index),
            static_cast<std::uint8_t>(index >> 8),
            static_cast<std::uint8_t>(length),
            static_cast<std::uint8_t>(length >> 8)};
  }
};

/// `data`: of the data stage, where that goes to the device.
inline usbip::Urb control_urb(const SetupFields& setup, std::vector<std::uint8_t> data) {
  usbip::Urb urb;
  urb.to_host = setup.to_host();
  urb.setup = setup.bytes();
  urb.length = setup.length;
  urb.bytes = std::move(data);
  return urb;
}

}  // namespace umov::test
