// The chip's USB device controller (OTG_FS) as the firmware's USB stack wants it.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "firmware/core/usb/port.hpp"

namespace umov::boards::stm32f407 {

/// Contexts: all of it in the main loop. The interrupt does no more than wake it: on_interrupt()
/// holds further ones off until poll() has done what there was to do.
class UsbPort final : public firmware::usb::Port {
 public:
  /// Once, before the watchdog runs: takes 25 ms. Nothing is shown to the host yet.
  void set_up();
  void on_interrupt();
  /// Tells `events` what has happened.
  void poll(firmware::usb::PortEvents& events);

  void connect() override;
  void disconnect() override;
  void set_address(std::uint8_t address) override;
  void open_endpoint(firmware::usb::EndpointAddress address, firmware::usb::EndpointType type,
                     std::uint16_t max_packet) override;
  void close_endpoint(firmware::usb::EndpointAddress address) override;
  void send(firmware::usb::EndpointAddress address, std::span<const std::uint8_t> bytes) override;
  void receive(firmware::usb::EndpointAddress address, std::span<std::uint8_t> buffer) override;
  void stall(firmware::usb::EndpointAddress address) override;
  void clear_stall(firmware::usb::EndpointAddress address) override;

 private:
  static constexpr unsigned endpoint_count = 4;

  /// What the FIFO of an IN endpoint can hold is sent in one go; a longer transfer in several.
  struct Sending {
    std::span<const std::uint8_t> rest{};
    bool active = false;
  };
  struct Receiving {
    std::span<std::uint8_t> buffer{};
    std::size_t size = 0;
    bool active = false;
  };

  void begin_anew();
  void prepare_setup();
  void send_next(unsigned endpoint);
  void take_received();
  void read_fifo(std::span<std::uint8_t> into, std::size_t size);
  void look_at_in(firmware::usb::PortEvents& events);
  void look_at_out(firmware::usb::PortEvents& events);
  void abandon_in(unsigned endpoint);
  void abandon_out(unsigned endpoint);

  std::array<Sending, endpoint_count> sending_{};
  std::array<Receiving, endpoint_count> receiving_{};
  std::array<std::uint16_t, endpoint_count> in_packet_{64, 64, 64, 64};
  firmware::usb::SetupPacket setup_{};
};

}  // namespace umov::boards::stm32f407
