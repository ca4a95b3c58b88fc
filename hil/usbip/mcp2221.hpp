// A MCP2221A, USB to GPIO: as much of it as Linux' driver hid-mcp2221 uses for its four pins.
// Source: Microchip DS20005565, "MCP2221A", sections 3.1.1 (STATUS), 3.1.11 and 3.1.12 (GPIO).
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "firmware/core/usb/control_pipe.hpp"
#include "firmware/core/usb/port.hpp"
#include "hil/usbip/gpio_lines.hpp"
#include "hil/usbip/stack_port.hpp"
#include "hil/usbip/usb_function.hpp"

namespace umov::usbip {

/// The HID interface alone: the chip's serial port is left out, and so are I²C, its flash and the
/// pins' other functions (answered "not supported"). All pins begin as inputs.
///
/// Two things are not as on the chip, for the sake of the driver of Linux 6.1:
/// - The first two status requests and the first four requests for pin levels after plugging in are
///   stalled. While it probes, the driver drops answers and would wait four seconds for each.
/// - An input's level stands in the byte of the direction, too, which is where that driver looks
///   for it.
class Mcp2221 final : public UsbFunction,
                      private firmware::usb::PortEvents,
                      private firmware::usb::ControlHandler {
 public:
  static constexpr int pin_count = 4;

  /// `lines` must outlive the adapter.
  explicit Mcp2221(GpioLines& lines);

  // UsbFunction
  void bus_reset() override;
  Handshake setup(const std::array<std::uint8_t, 8>& packet) override {
    return port_.setup(packet);
  }
  Handshake out(std::uint8_t endpoint, std::span<const std::uint8_t> bytes) override;
  Handshake in(std::uint8_t endpoint, Packet& packet) override {
    return port_.in(endpoint, packet);
  }

 private:
  struct Pin {
    bool output = false;
    bool level = false;  ///< as an output
  };
  using Report = std::array<std::uint8_t, packet_bytes>;

  // PortEvents
  void on_reset() override;
  void on_suspend() override {}
  void on_resume() override {}
  void on_setup(const firmware::usb::SetupPacket& packet) override { control_.on_setup(packet); }
  void on_sent(firmware::usb::EndpointAddress address) override;
  void on_received(firmware::usb::EndpointAddress address, std::size_t size) override;
  // ControlHandler
  firmware::usb::ControlAnswer on_request(const firmware::usb::Request& request) override;
  bool on_data(const firmware::usb::Request&, std::span<const std::uint8_t>) override {
    return false;
  }
  void on_complete(const firmware::usb::Request&) override {}

  void carry_out(std::span<const std::uint8_t> command);
  void set_pins(std::span<const std::uint8_t> command);
  void get_pins(Report& answer) const;
  bool probing(std::span<const std::uint8_t> command);
  void open();

  GpioLines* lines_;
  StackPort port_;
  firmware::usb::ControlPipe control_;
  std::array<Pin, pin_count> pins_{};
  std::array<std::uint8_t, 1> configuration_{};
  Report received_{};
  Report answer_{};
  int status_requests_ = 0;
  int level_requests_ = 0;
};

}  // namespace umov::usbip
