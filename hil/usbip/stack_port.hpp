// A device controller made of nothing: the firmware's USB stack above it, a bus below. It checks
// what the stack does against the contract of firmware/core/usb/port.hpp and throws
// std::logic_error where that is broken.
#pragma once

#include <array>
#include <optional>
#include <span>

#include "firmware/core/usb/port.hpp"
#include "hil/usbip/usb_function.hpp"

namespace umov::usbip {

class StackPort final : public firmware::usb::Port, public UsbFunction {
 public:
  /// Must be called before anything happens on the bus; `events` must outlive the port.
  void bind(firmware::usb::PortEvents& events) { events_ = &events; }
  bool connected() const { return connected_; }
  std::uint8_t address() const { return address_; }

  // firmware::usb::Port
  void connect() override { connected_ = true; }
  void disconnect() override { connected_ = false; }
  void set_address(std::uint8_t address) override { address_ = address; }
  void open_endpoint(firmware::usb::EndpointAddress address, firmware::usb::EndpointType type,
                     std::uint16_t max_packet) override;
  void close_endpoint(firmware::usb::EndpointAddress address) override;
  void send(firmware::usb::EndpointAddress address, std::span<const std::uint8_t> bytes) override;
  void receive(firmware::usb::EndpointAddress address, std::span<std::uint8_t> buffer) override;
  void stall(firmware::usb::EndpointAddress address) override;
  void clear_stall(firmware::usb::EndpointAddress address) override;

  // UsbFunction
  void bus_reset() override;
  Handshake setup(const std::array<std::uint8_t, 8>& packet) override;
  Handshake out(std::uint8_t endpoint, std::span<const std::uint8_t> bytes) override;
  Handshake in(std::uint8_t endpoint, Packet& packet) override;

 private:
  struct Endpoint {
    bool open = false;
    bool halted = false;
    std::size_t max_packet = packet_bytes;
    std::optional<std::span<const std::uint8_t>> sending;
    std::optional<std::span<std::uint8_t>> receiving;
    std::size_t received = 0;

    void abandon() {
      sending.reset();
      receiving.reset();
      received = 0;
    }
  };
  static constexpr std::size_t endpoint_count = 16;
  Endpoint& endpoint(firmware::usb::EndpointAddress address);

  firmware::usb::PortEvents* events_ = nullptr;
  bool connected_ = false;
  std::uint8_t address_ = 0;
  std::array<Endpoint, endpoint_count> in_{};
  std::array<Endpoint, endpoint_count> out_{};
};

}  // namespace umov::usbip
