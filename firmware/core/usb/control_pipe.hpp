// Endpoint 0: takes a control transfer through its setup, data and status stages (USB 2.0,
// sections 8.5.3 and 9.3). What a request means, a ControlHandler knows.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/core/usb/chapter9.hpp"
#include "firmware/core/usb/port.hpp"

namespace umov::firmware::usb {

/// What is to be done with a request.
struct ControlAnswer {
  enum class Kind : std::uint8_t { refuse, accept, reply, take };
  Kind kind = Kind::refuse;
  std::span<const std::uint8_t> data{};  ///< reply: valid until the next SETUP packet
  std::span<std::uint8_t> room{};        ///< take: where the host's data goes; the same

  /// STALL.
  static constexpr ControlAnswer refuse() { return {}; }
  /// A request without data.
  static constexpr ControlAnswer accept() { return {Kind::accept, {}, {}}; }
  /// Data for the host, cut to what it asks for.
  static constexpr ControlAnswer reply(std::span<const std::uint8_t> data) {
    return {Kind::reply, data, {}};
  }
  /// Takes data from the host; more than fits is refused.
  static constexpr ControlAnswer take(std::span<std::uint8_t> room) {
    return {Kind::take, {}, room};
  }
};

class ControlHandler {
 public:
  /// A request has arrived.
  virtual ControlAnswer on_request(const Request& request) = 0;
  /// All data of a request answered by `take` is there; false: refused.
  virtual bool on_data(const Request& request, std::span<const std::uint8_t> data) = 0;
  /// The status stage is over: the host knows that the request was carried out.
  virtual void on_complete(const Request& request) = 0;

 protected:
  ControlHandler() = default;
  ControlHandler(const ControlHandler&) = default;
  ControlHandler& operator=(const ControlHandler&) = default;
  ~ControlHandler() = default;
};

class ControlPipe {
 public:
  ControlPipe(Port& port, ControlHandler& handler) : port_(&port), handler_(&handler) {}

  void reset() { stage_ = Stage::idle; }
  void on_setup(const SetupPacket& packet);
  void on_sent();
  void on_received(std::size_t size);

 private:
  enum class Stage : std::uint8_t { idle, data_in, data_out, status_in, status_out };

  void send_next();
  void receive_next();
  void refuse();
  void end();

  Port* port_;
  ControlHandler* handler_;
  Stage stage_ = Stage::idle;
  bool short_end_ = false;  ///< the reply ends before what was asked for
  bool ended_ = false;      ///< the packet that ends the reply has been given to the port
  Request request_{};
  std::span<const std::uint8_t> to_send_{};
  std::span<std::uint8_t> room_{};
  std::size_t received_ = 0;
  std::array<std::uint8_t, max_packet_bytes> packet_{};
};

}  // namespace umov::firmware::usb
