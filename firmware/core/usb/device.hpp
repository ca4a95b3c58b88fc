// The controller as a USB device: standard, class and vendor requests, and the pipes behind them.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "firmware/core/usb/application.hpp"
#include "firmware/core/usb/control_pipe.hpp"
#include "firmware/core/usb/descriptors.hpp"
#include "firmware/core/usb/link_switch.hpp"
#include "firmware/core/usb/port.hpp"
#include "firmware/core/usb/standard_requests.hpp"

namespace umov::firmware::usb {

/// One a board, statically allocated; port and application must outlive it. All calls from one
/// context, the main loop.
class Device final : public PortEvents, private ControlHandler {
 public:
  /// `serial`: ASCII, up to 24 characters, padded with zeros.
  /// `line`: a serial line of the board that carries the protocol as well; may be null.
  Device(Port& port, Application& application, const std::array<char, 24>& serial,
         SerialLine* line = nullptr);

  /// Shows the device to the host.
  void start() { port_->connect(); }
  /// Each millisecond, with the time from anywhere, microseconds.
  void tick(std::uint64_t now_us);

  /// Whether a host has the link.
  bool has_host() const { return links_.owned(); }
  /// For Board::link_room and Board::write_link.
  std::size_t link_room() const { return links_.room(); }
  bool write_link(std::span<const std::uint8_t> frame) { return links_.write(frame); }
  /// Bytes that came over the serial line.
  void take_serial(std::span<const std::uint8_t> bytes) { links_.take_serial(bytes); }

  bool configured() const { return configuration_ != 0; }

  // PortEvents
  void on_reset() override;
  void on_suspend() override {}
  void on_resume() override {}
  void on_setup(const SetupPacket& packet) override { control_.on_setup(packet); }
  void on_sent(EndpointAddress address) override;
  void on_received(EndpointAddress address, std::size_t size) override;

 private:
  // device.cpp
  void set_configuration(std::uint8_t value);
  void send_hand_state();
  // requests.cpp
  ControlAnswer on_request(const Request& request) override;
  bool on_data(const Request& request, std::span<const std::uint8_t> data) override;
  void on_complete(const Request& request) override;
  ControlAnswer on_standard(const Request& request);
  ControlAnswer on_class(const Request& request);
  ControlAnswer on_vendor(const Request& request);
  ControlAnswer get_status(const Request& request);
  ControlAnswer change_halt(const Request& request, bool halt);
  ControlAnswer get_descriptor(const Request& request) const;
  bool has_interface(const Request& request) const;
  ControlAnswer small_reply(std::size_t size);

  Port* port_;
  Application* application_;
  ControlPipe control_;
  LinkSwitch links_;
  SerialString serial_;
  std::uint8_t configuration_ = 0;
  std::uint16_t halted_ = 0;  ///< bit n: OUT n, bit 8 + n: IN n
  bool detaching_ = false;
  std::array<std::uint8_t, max_packet_bytes> room_{};    ///< data stages from the host
  std::array<std::uint8_t, hand_report_bytes> small_{};  ///< short data stages to the host
  std::uint8_t hand_axis_ = 0;
  bool hand_sending_ = false;
  bool hand_told_ = false;
  HandState hand_state_{};  ///< told last
  std::array<std::uint8_t, hand_report_bytes> hand_bytes_{};
};

}  // namespace umov::firmware::usb
