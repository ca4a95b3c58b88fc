// What the controller says of itself on USB: one configuration with four interfaces.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/core/usb/descriptor_builder.hpp"
#include "firmware/core/usb/ms_os_20.hpp"
#include "firmware/core/usb/standard_requests.hpp"
#include "protocol/usb.hpp"

namespace umov::firmware::usb {

using protocol::usb::bulk_in;
using protocol::usb::bulk_out;
using protocol::usb::hand_in;
using protocol::usb::hand_report_bytes;
using protocol::usb::product_id;
using protocol::usb::report_bytes;
using protocol::usb::reports_in;
using protocol::usb::reports_out;
using protocol::usb::vendor_id;
namespace interface = protocol::usb::interface;

/// Revision of this set of descriptors, bcdDevice.
inline constexpr std::uint16_t device_revision = 0x0100;

namespace string_index {
inline constexpr std::uint8_t manufacturer = 1;
inline constexpr std::uint8_t product = 2;
inline constexpr std::uint8_t serial = serial_index;
inline constexpr std::uint8_t bulk = 4;
inline constexpr std::uint8_t reports = 5;
inline constexpr std::uint8_t hand = 6;
inline constexpr std::uint8_t dfu = 7;
}  // namespace string_index

inline constexpr auto manufacturer_text = string_descriptor("Umov");
inline constexpr auto product_text = string_descriptor("Umov reflectometer controller");
inline constexpr auto bulk_text = string_descriptor("Umov protocol");
inline constexpr auto reports_text = string_descriptor("Umov protocol in reports");
inline constexpr auto hand_text = string_descriptor("Umov hand controller");
inline constexpr auto dfu_text = string_descriptor("Umov firmware update");
/// English (United States), the one language.
inline constexpr Bytes<4> language_ids = {4, static_cast<std::uint8_t>(DescriptorType::string),
                                          0x09, 0x04};

/// The OTG_FS of an STM32F4 has three endpoints besides 0 in each direction.
inline constexpr std::uint8_t most_endpoints = 3;

/// bInterfaceSubClass and bInterfaceProtocol of the bulk interface: 'U', protocol version 1.
inline constexpr InterfaceClass bulk_class = {0xff, 0x55, 0x01};
inline constexpr InterfaceClass hid_class = {0x03, 0x00, 0x00};
inline constexpr InterfaceClass dfu_runtime_class = {0xfe, 0x01, 0x01};

/// The protocol: 64 bytes each way, padded with zeros, and one byte that tells whether a program is
/// there. Vendor-defined usage page FF00, usage 1.
inline constexpr Bytes<33> reports_descriptor = {
    0x06, 0x00,
    0xff,        // usage page (vendor-defined)
    0x09, 0x01,  // usage (1)
    0xa1, 0x01,  // collection (application)
    0x15, 0x00,  //   logical minimum (0)
    0x26, 0xff,
    0x00,                                        //   logical maximum (255)
    0x75, 0x08,                                  //   report size (8)
    0x95, report_bytes,                          // report count
    0x09, 0x02,                                  //   usage (2)
    0x81, 0x02,                                  //   input (data, variable, absolute)
    0x09, 0x03,                                  //   usage (3)
    0x91, 0x02,                                  //   output (data, variable, absolute)
    0x95, protocol::usb::presence_report_bytes,  // report count
    0x09, 0x04,                                  //   usage (4): a program is there, 1, or leaves, 0
    0xb1, 0x02,                                  //   feature (data, variable, absolute)
    0xc0,                                        // end collection
};
/// The hand controller: usage 0x10 of the same page.
inline constexpr Bytes<27> hand_descriptor = {
    0x06, 0x00,
    0xff,        // usage page (vendor-defined)
    0x09, 0x10,  // usage (16)
    0xa1, 0x01,  // collection (application)
    0x15, 0x00,  //   logical minimum (0)
    0x26, 0xff,
    0x00,                     //   logical maximum (255)
    0x75, 0x08,               //   report size (8)
    0x95, hand_report_bytes,  // report count
    0x09, 0x11,               //   usage (17)
    0x81, 0x02,               //   input (data, variable, absolute)
    0x09, 0x12,               //   usage (18)
    0x91, 0x02,               //   output (data, variable, absolute)
    0xc0,                     // end collection
};

inline constexpr Bytes<18> device_descriptor = {
    18,
    static_cast<std::uint8_t>(DescriptorType::device),
    0x10,
    0x02,  // USB 2.1: there is a BOS descriptor
    0,
    0,
    0,  // class: see the interfaces
    max_packet_bytes,
    low_byte(vendor_id),
    high_byte(vendor_id),
    low_byte(product_id),
    high_byte(product_id),
    low_byte(device_revision),
    high_byte(device_revision),
    string_index::manufacturer,
    string_index::product,
    string_index::serial,
    1,
};

/// DFU attributes: downloads, uploads, answers after manifestation, detaches by itself.
inline constexpr std::uint8_t dfu_attributes = 0x0f;
inline constexpr std::uint16_t dfu_detach_timeout_ms = 1000;
inline constexpr std::uint16_t dfu_transfer_bytes = 1024;
inline constexpr Bytes<9> dfu_descriptor =
    dfu_functional(dfu_attributes, dfu_detach_timeout_ms, dfu_transfer_bytes);
inline constexpr Bytes<9> reports_hid_descriptor = hid_descriptor(reports_descriptor.size());
inline constexpr Bytes<9> hand_hid_descriptor = hid_descriptor(hand_descriptor.size());

/// The board draws its motors' power from elsewhere; of the bus it takes 100 mA.
inline constexpr auto configuration = configuration_descriptor(
    join(interface_descriptor(interface::bulk, 2, bulk_class, string_index::bulk),
         endpoint_descriptor(bulk_out, EndpointType::bulk, max_packet_bytes, 0),
         endpoint_descriptor(bulk_in, EndpointType::bulk, max_packet_bytes, 0),
         interface_descriptor(interface::reports, 2, hid_class, string_index::reports),
         reports_hid_descriptor,
         endpoint_descriptor(reports_in, EndpointType::interrupt, report_bytes, 1),
         endpoint_descriptor(reports_out, EndpointType::interrupt, report_bytes, 1),
         interface_descriptor(interface::hand, 1, hid_class, string_index::hand),
         hand_hid_descriptor,
         endpoint_descriptor(hand_in, EndpointType::interrupt, hand_report_bytes, 10),
         interface_descriptor(interface::dfu, 0, dfu_runtime_class, string_index::dfu),
         dfu_descriptor),
    0x40, 100);
static_assert(well_formed_configuration(configuration, most_endpoints));
static_assert(configuration[4] == interface::count);

/// By which Windows programs find the bulk interface.
inline constexpr auto windows_descriptors = ms_os_20::descriptor_set(join(
    ms_os_20::function(
        interface::bulk,
        join(ms_os_20::winusb, ms_os_20::interface_guid("{3C1D2F0B-6B0E-4E0C-9A57-5B3F1C7A92E4}"))),
    ms_os_20::function(interface::dfu, ms_os_20::winusb)));

/// BOS: no link power management, Windows descriptors.
inline constexpr auto bos_descriptor = [] {
  constexpr Bytes<7> usb2_extension = {
      7, static_cast<std::uint8_t>(DescriptorType::device_capability), 2, 0, 0, 0, 0};
  constexpr auto capabilities =
      join(usb2_extension, ms_os_20::platform_capability(windows_descriptors.size()));
  constexpr std::size_t size = capabilities.size() + 5;
  return join(Bytes<5>{5, static_cast<std::uint8_t>(DescriptorType::bos), low_byte(size),
                       high_byte(size), 2},
              capabilities);
}();

/// By index; the serial number is the device's own.
inline constexpr std::array<std::span<const std::uint8_t>, 8> strings = {
    language_ids, manufacturer_text, product_text, {},
    bulk_text,    reports_text,      hand_text,    dfu_text};
static_assert(strings.size() == string_index::dfu + 1u && strings[string_index::serial].empty());

inline constexpr DescriptorTable descriptor_table = {device_descriptor, configuration,
                                                     bos_descriptor, strings};

/// The serial number of a chip: its 96-bit id as 24 hexadecimal digits, highest first.
constexpr std::array<char, 24> serial_of_chip(const std::array<std::uint32_t, 3>& chip_id) {
  std::array<char, 24> text{};
  for (std::size_t i = 0; i < text.size(); ++i) {
    const std::uint32_t word = chip_id[2 - i / 8];
    text[i] = "0123456789ABCDEF"[(word >> (28 - 4 * (i % 8))) & 0xfu];
  }
  return text;
}

}  // namespace umov::firmware::usb
