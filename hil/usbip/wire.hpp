// USB/IP on the wire: big-endian headers (Linux, Documentation/usb/usbip_protocol.rst, version
// 1.1.1).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace umov::usbip::wire {

inline constexpr std::uint16_t version = 0x0111;
inline constexpr std::uint16_t request_list = 0x8005;
inline constexpr std::uint16_t reply_list = 0x0005;
inline constexpr std::uint16_t request_import = 0x8003;
inline constexpr std::uint16_t reply_import = 0x0003;
inline constexpr std::size_t operation_header_bytes = 8;
inline constexpr std::size_t bus_id_bytes = 32;

inline constexpr std::uint32_t command_submit = 1;
inline constexpr std::uint32_t command_unlink = 2;
inline constexpr std::uint32_t return_submit = 3;
inline constexpr std::uint32_t return_unlink = 4;
inline constexpr std::size_t header_bytes = 48;
inline constexpr std::uint32_t zero_packet_flag = 0x40;  ///< URB_ZERO_PACKET in transfer_flags
inline constexpr std::uint32_t full_speed = 2;           ///< enum usb_device_speed

/// Appends big-endian numbers and padded texts.
class Writer {
 public:
  explicit Writer(std::vector<std::uint8_t>& out) : out_(&out) {}
  Writer& u8(std::uint8_t value) {
    out_->push_back(value);
    return *this;
  }
  Writer& u16(std::uint16_t value) {
    return u8(static_cast<std::uint8_t>(value >> 8)).u8(static_cast<std::uint8_t>(value & 0xffu));
  }
  Writer& u32(std::uint32_t value) {
    return u16(static_cast<std::uint16_t>(value >> 16)).u16(static_cast<std::uint16_t>(value));
  }
  Writer& text(std::string_view text, std::size_t size) {
    for (std::size_t i = 0; i < size; ++i) {
      u8(i < text.size() ? static_cast<std::uint8_t>(text[i]) : std::uint8_t{0});
    }
    return *this;
  }
  Writer& bytes(std::span<const std::uint8_t> bytes) {
    out_->insert(out_->end(), bytes.begin(), bytes.end());
    return *this;
  }

 private:
  std::vector<std::uint8_t>* out_;
};

inline std::uint16_t u16_at(std::span<const std::uint8_t> bytes, std::size_t at) {
  return static_cast<std::uint16_t>((bytes[at] << 8) | bytes[at + 1]);
}
inline std::uint32_t u32_at(std::span<const std::uint8_t> bytes, std::size_t at) {
  return (static_cast<std::uint32_t>(u16_at(bytes, at)) << 16) | u16_at(bytes, at + 2);
}

/// A host's command: the 48 bytes before any data.
struct Command {
  std::uint32_t command = 0;
  std::uint32_t number = 0;
  bool to_host = false;
  std::uint32_t endpoint = 0;
  std::uint32_t flags = 0;
  std::uint32_t length = 0;
  std::uint32_t iso_packets = 0;
  std::uint32_t unlink_number = 0;
  std::array<std::uint8_t, 8> setup{};
};

inline Command parse_command(std::span<const std::uint8_t, header_bytes> h) {
  Command c;
  c.command = u32_at(h, 0);
  c.number = u32_at(h, 4);
  c.to_host = u32_at(h, 12) != 0;
  c.endpoint = u32_at(h, 16);
  if (c.command == command_unlink) {
    c.unlink_number = u32_at(h, 20);
    return c;
  }
  c.flags = u32_at(h, 20);
  c.length = u32_at(h, 24);
  c.iso_packets = u32_at(h, 32);
  for (std::size_t i = 0; i < 8; ++i) c.setup[i] = h[40 + i];
  return c;
}

inline void write_return_submit(std::vector<std::uint8_t>& out, std::uint32_t number,
                                std::int32_t status, std::size_t transferred) {
  Writer(out)
      .u32(return_submit)
      .u32(number)
      .u32(0)
      .u32(0)
      .u32(0)
      .u32(static_cast<std::uint32_t>(status))
      .u32(static_cast<std::uint32_t>(transferred))
      .u32(0)
      .u32(0)
      .u32(0)
      .text("", 8);
}

inline void write_return_unlink(std::vector<std::uint8_t>& out, std::uint32_t number,
                                std::int32_t status) {
  Writer(out)
      .u32(return_unlink)
      .u32(number)
      .u32(0)
      .u32(0)
      .u32(0)
      .u32(static_cast<std::uint32_t>(status))
      .text("", 24);
}

}  // namespace umov::usbip::wire
