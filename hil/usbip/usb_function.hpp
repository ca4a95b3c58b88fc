// A full-speed USB device as its bus sees it: one transaction at a time.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace umov::usbip {

inline constexpr std::size_t packet_bytes = 64;

/// Answer to a transaction. `none`: no such endpoint, or nothing is plugged in.
enum class Handshake : std::uint8_t { ack, nak, stall, none };

struct Packet {
  std::array<std::uint8_t, packet_bytes> bytes{};
  std::size_t size = 0;
  std::span<const std::uint8_t> view() const { return {bytes.data(), size}; }
};

class UsbFunction {
 public:
  virtual ~UsbFunction() = default;
  /// The device has been plugged in: address 0, not configured.
  virtual void bus_reset() = 0;
  /// SETUP on endpoint 0; a device must take it.
  virtual Handshake setup(const std::array<std::uint8_t, 8>& packet) = 0;
  /// OUT with data of at most the endpoint's size. nak: nothing was taken, try again later.
  virtual Handshake out(std::uint8_t endpoint, std::span<const std::uint8_t> bytes) = 0;
  /// IN; `packet` is filled when the answer is ack.
  virtual Handshake in(std::uint8_t endpoint, Packet& packet) = 0;
};

}  // namespace umov::usbip
