// Names and numbers of the USB 2.0 specification that the stack uses (chapter 9, HID 1.11, DFU
// 1.1).
#pragma once

#include <cstdint>

#include "firmware/core/usb/port.hpp"

namespace umov::firmware::usb {

/// bDescriptorType, table 9-5 and the class specifications.
enum class DescriptorType : std::uint8_t {
  device = 1,
  configuration = 2,
  string = 3,
  interface = 4,
  endpoint = 5,
  device_qualifier = 6,
  bos = 15,
  device_capability = 16,
  hid = 0x21,  ///< also the functional descriptor of DFU
  hid_report = 0x22,
};
inline constexpr std::uint8_t dfu_functional_descriptor = 0x21;

/// bRequest of standard requests, table 9-4.
namespace standard {
inline constexpr std::uint8_t get_status = 0;
inline constexpr std::uint8_t clear_feature = 1;
inline constexpr std::uint8_t set_feature = 3;
inline constexpr std::uint8_t set_address = 5;
inline constexpr std::uint8_t get_descriptor = 6;
inline constexpr std::uint8_t get_configuration = 8;
inline constexpr std::uint8_t set_configuration = 9;
inline constexpr std::uint8_t get_interface = 10;
inline constexpr std::uint8_t set_interface = 11;
inline constexpr std::uint16_t endpoint_halt = 0;  ///< feature selector
}  // namespace standard

/// bRequest of the HID class, HID 1.11 section 7.2.
namespace hid {
inline constexpr std::uint8_t get_report = 1;
inline constexpr std::uint8_t get_idle = 2;
inline constexpr std::uint8_t set_report = 9;
inline constexpr std::uint8_t set_idle = 10;
inline constexpr std::uint8_t input_report = 1;    ///< high byte of wValue
inline constexpr std::uint8_t output_report = 2;   ///< high byte of wValue
inline constexpr std::uint8_t feature_report = 3;  ///< high byte of wValue
}  // namespace hid

/// bRequest and values of the DFU class, DFU 1.1 sections 3 and 6.1.
namespace dfu {
inline constexpr std::uint8_t detach = 0;
inline constexpr std::uint8_t get_status = 3;
inline constexpr std::uint8_t get_state = 5;
inline constexpr std::uint8_t state_app_idle = 0;
inline constexpr std::uint8_t state_app_detach = 1;
inline constexpr std::uint8_t status_ok = 0;
}  // namespace dfu

enum class RequestKind : std::uint8_t {
  standard = 0,
  class_specific = 1,
  vendor = 2,
  reserved = 3
};
enum class Recipient : std::uint8_t { device = 0, interface = 1, endpoint = 2, other = 3 };

/// A SETUP packet taken apart (table 9-2).
struct Request {
  bool to_host = false;  ///< direction of the data stage
  RequestKind kind = RequestKind::standard;
  Recipient recipient = Recipient::device;
  std::uint8_t number = 0;  ///< bRequest
  std::uint16_t value = 0;
  std::uint16_t index = 0;
  std::uint16_t length = 0;

  constexpr std::uint8_t value_high() const { return static_cast<std::uint8_t>(value >> 8); }
  constexpr std::uint8_t value_low() const { return static_cast<std::uint8_t>(value & 0xffu); }
};

constexpr Request parse_setup(const SetupPacket& p) {
  Request r;
  r.to_host = (p[0] & 0x80u) != 0;
  r.kind = static_cast<RequestKind>((p[0] >> 5) & 3u);
  const std::uint8_t recipient = p[0] & 0x1fu;
  r.recipient = recipient < 3 ? static_cast<Recipient>(recipient) : Recipient::other;
  r.number = p[1];
  r.value = static_cast<std::uint16_t>(p[2] | (p[3] << 8));
  r.index = static_cast<std::uint16_t>(p[4] | (p[5] << 8));
  r.length = static_cast<std::uint16_t>(p[6] | (p[7] << 8));
  return r;
}

}  // namespace umov::firmware::usb
