// The boot loader as a USB device: standard requests, and the update behind them.
#pragma once

#include <array>
#include <cstdint>

#include "firmware/boot/descriptors.hpp"
#include "firmware/boot/dfu_target.hpp"
#include "firmware/core/usb/control_pipe.hpp"
#include "firmware/core/usb/port.hpp"

namespace umov::firmware::boot {

/// One a board; all calls from one context. `development_key`: say so in the product's name. `why`:
/// the controller has no program to start, none otherwise.
class BootDevice final : public usb::PortEvents, private usb::ControlHandler {
 public:
  BootDevice(usb::Port& port, Flash& flash, const Trust& trust, const std::array<char, 24>& serial,
             bool development_key, Reason why = Reason::none);

  void start() { port_->connect(); }
  /// Again and again.
  void work() { target_.work(); }
  /// There is work to be done now, without waiting for the host.
  bool working() const { return target_.working(); }
  /// DFU mode is over: reset the chip.
  bool leaving() const { return reset_ || target_.leaving(); }

  // usb::PortEvents
  void on_reset() override;
  void on_suspend() override {}
  void on_resume() override {}
  void on_setup(const usb::SetupPacket& packet) override { control_.on_setup(packet); }
  void on_sent(usb::EndpointAddress address) override;
  void on_received(usb::EndpointAddress address, std::size_t size) override;

 private:
  usb::ControlAnswer on_request(const usb::Request& request) override;
  bool on_data(const usb::Request& request, std::span<const std::uint8_t> data) override;
  void on_complete(const usb::Request& request) override;
  usb::ControlAnswer on_standard(const usb::Request& request);
  usb::ControlAnswer get_descriptor(const usb::Request& request) const;

  usb::Port* port_;
  usb::ControlPipe control_;
  DfuTarget target_;
  usb::SerialString serial_;
  std::array<std::uint8_t, 2> small_{};
  const usb::DescriptorTable* descriptors_;
  std::uint8_t configuration_ = 0;
  std::uint8_t setting_ = 0;
  bool reset_ = false;
};

}  // namespace umov::firmware::boot
