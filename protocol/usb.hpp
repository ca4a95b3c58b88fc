// What both ends of a USB cable must agree on: ids, interfaces, endpoints.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace umov::protocol::usb {

/// pid.codes, a vendor id that open projects share, and the first of its product ids for tests
/// (https://pid.codes/1209/0001/). Those are free to use and belong to nobody: a host looks at the
/// manufacturer's name, too, and a product that is sold needs an id of its own.
inline constexpr std::uint16_t vendor_id = 0x1209;
inline constexpr std::uint16_t product_id = 0x0001;
/// The second one: a controller in its boot loader.
inline constexpr std::uint16_t update_product_id = 0x0002;
/// String descriptor 1 of every Umov controller.
inline constexpr std::string_view manufacturer = "Umov";

/// bInterfaceNumber.
namespace interface {
inline constexpr std::uint8_t bulk = 0;     ///< the protocol over two bulk pipes
inline constexpr std::uint8_t reports = 1;  ///< the same in HID reports of 64 bytes
inline constexpr std::uint8_t hand = 2;     ///< a hand controller's jog reports
inline constexpr std::uint8_t dfu = 3;      ///< DFU run-time: "detach"
inline constexpr std::uint8_t count = 4;
}  // namespace interface

/// Endpoint addresses; bit 7 is the direction to the host.
inline constexpr std::uint8_t bulk_out = 0x01;
inline constexpr std::uint8_t bulk_in = 0x81;
inline constexpr std::uint8_t reports_out = 0x02;
inline constexpr std::uint8_t reports_in = 0x82;
inline constexpr std::uint8_t hand_in = 0x83;

/// Length of the protocol's HID reports, both ways: frames, padded with zeros (empty frames).
inline constexpr std::size_t report_bytes = 64;
/// Length of a hand controller's reports, both ways.
inline constexpr std::size_t hand_report_bytes = 8;

/// A program tells when it opens the pipe and when it leaves, so that another need not wait until
/// it has been silent for a while: on the bulk interface by this vendor request without data,
/// wValue 1 or 0; on the report interface by a feature report of one byte, 1 or 0.
inline constexpr std::uint8_t request_user_present = 0x02;
inline constexpr std::size_t presence_report_bytes = 1;

}  // namespace umov::protocol::usb
