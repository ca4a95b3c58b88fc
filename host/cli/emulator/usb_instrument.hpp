// The emulated instrument behind its USB connector: the firmware's USB stack between the native
// board and a virtual cable.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "firmware/core/usb/application.hpp"
#include "firmware/core/usb/device.hpp"
#include "hil/usbip/stack_port.hpp"
#include "host/cli/emulator/emulated_instrument.hpp"

namespace umov::emulator {

/// Owns the instrument; not thread-safe.
class UsbInstrument final : private firmware::usb::Application {
 public:
  /// `link_time_us` as in NativeBoardOptions; it is the USB stack's clock, too. `on_event` may be
  /// empty.
  UsbInstrument(const BenchOptions& options, std::function<std::uint64_t()> link_time_us,
                std::function<void(const std::string&)> on_event = {});

  EmulatedInstrument& instrument() { return instrument_; }
  usbip::UsbFunction& function() { return port_; }
  /// Lets virtual time pass and hands the board's bytes to the USB stack as far as there is room.
  void run_for(std::uint64_t duration_us);
  /// Nothing happens until the host says something (or reads: what it has not read waits).
  bool at_rest() const { return instrument_.board().resting(); }

 private:
  void on_link_bytes(std::span<const std::uint8_t> bytes) override;
  void on_hand_report(const firmware::usb::HandReport& report) override;
  firmware::usb::HandState hand_state(std::uint8_t axis) const override;
  /// A process has no boot loader.
  bool detach_allowed() const override { return false; }
  void on_detach() override;
  void pump();

  std::function<std::uint64_t()> time_us_;
  std::function<void(const std::string&)> on_event_;
  EmulatedInstrument instrument_;
  usbip::StackPort port_;
  firmware::usb::Device device_;
  std::vector<std::uint8_t> output_;
  std::size_t written_ = 0;
};

}  // namespace umov::emulator
