// What the USB stack needs of a chip's device controller, and what it is told by it. One
// implementation a board (and one for a virtual cable); the stack knows no register.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace umov::firmware::usb {

/// Endpoint number with the direction in bit 7, as in endpoint descriptors: 0x81 is IN 1, 0x01 is
/// OUT 1. IN means towards the host.
using EndpointAddress = std::uint8_t;
inline constexpr EndpointAddress direction_in = 0x80;
inline constexpr EndpointAddress control_in = 0x80;
inline constexpr EndpointAddress control_out = 0x00;
constexpr std::uint8_t endpoint_number(EndpointAddress address) {
  return address & 0x0fu;
}
constexpr bool is_in(EndpointAddress address) {
  return (address & direction_in) != 0;
}

/// Largest packet of the control endpoint, and of bulk and interrupt endpoints at full speed.
inline constexpr std::size_t max_packet_bytes = 64;

/// Value of bmAttributes in the endpoint descriptor.
enum class EndpointType : std::uint8_t { control = 0, isochronous = 1, bulk = 2, interrupt = 3 };

using SetupPacket = std::array<std::uint8_t, 8>;

/// The device controller of a chip, at full speed. Transfers are asked for and reported later; at
/// most one is under way for each endpoint address. Buffers stay valid and untouched until the
/// transfer is reported or abandoned. Every call returns at once; all calls are made from the
/// context in which the board calls `PortEvents`.
class Port {
 public:
  /// Shows the device to the host (pull-up on D+), or takes it away.
  virtual void connect() = 0;
  virtual void disconnect() = 0;
  /// The address of SET_ADDRESS; called before its status stage. A controller that needs it only
  /// after that stage keeps it until then (that of the STM32F4 takes it at once).
  virtual void set_address(std::uint8_t address) = 0;

  /// Makes an endpoint other than 0 answer NAK from now on, data toggle at DATA0, not halted. A
  /// transfer under way on that address is abandoned.
  virtual void open_endpoint(EndpointAddress address, EndpointType type,
                             std::uint16_t max_packet) = 0;
  /// The endpoint answers nothing any more; a transfer under way is abandoned.
  virtual void close_endpoint(EndpointAddress address) = 0;

  /// Sends `bytes` in packets of the endpoint's size, the last one possibly shorter; an empty span
  /// is one packet of length zero. No packet of length zero is added: the stack does that. On
  /// `control_in` at most one packet is given at a time. Reported by `on_sent`.
  virtual void send(EndpointAddress address, std::span<const std::uint8_t> bytes) = 0;
  /// Takes packets into `buffer`, whose size is a multiple of the endpoint's packet size (or empty,
  /// on `control_out`, for a status stage), until it is full or a packet is shorter than the
  /// endpoint's size. Reported by `on_received`.
  virtual void receive(EndpointAddress address, std::span<std::uint8_t> buffer) = 0;

  /// Answers STALL; a transfer under way is abandoned. On endpoint 0 both directions are stalled,
  /// until the next SETUP packet.
  virtual void stall(EndpointAddress address) = 0;
  /// Ends the halt of an endpoint other than 0: NAK, data toggle at DATA0, a transfer under way is
  /// abandoned. Also called when it was not halted (the host may ask for that).
  virtual void clear_stall(EndpointAddress address) = 0;

 protected:
  Port() = default;
  Port(const Port&) = default;
  Port& operator=(const Port&) = default;
  ~Port() = default;  // never destroyed through the port: no heap
};

/// What a board's driver tells the stack; all from one context, the main loop.
class PortEvents {
 public:
  /// Reset on the bus: all endpoints but 0 are closed, the address is 0, transfers are abandoned.
  virtual void on_reset() = 0;
  /// The bus is idle for 3 ms, or the host is gone (VBUS, where the board sees it).
  virtual void on_suspend() = 0;
  virtual void on_resume() = 0;
  /// A SETUP packet arrived. It has ended whatever was under way on endpoint 0, in both directions;
  /// nothing of that may be reported afterwards.
  virtual void on_setup(const SetupPacket& packet) = 0;
  /// All of a `send` has reached the host.
  virtual void on_sent(EndpointAddress address) = 0;
  /// A `receive` has ended with so many bytes.
  virtual void on_received(EndpointAddress address, std::size_t size) = 0;

 protected:
  PortEvents() = default;
  PortEvents(const PortEvents&) = default;
  PortEvents& operator=(const PortEvents&) = default;
  ~PortEvents() = default;
};

}  // namespace umov::firmware::usb
