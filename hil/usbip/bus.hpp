// The host controller's part of the cable: turns the requests of a host (URBs) into transactions
// and keeps those that a device answers with NAK.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <list>
#include <vector>

#include "hil/usbip/usb_function.hpp"

namespace umov::usbip {

/// A request for one transfer.
struct Urb {
  std::uint32_t number = 0;
  std::uint8_t endpoint = 0;  ///< without direction
  bool to_host = false;
  bool add_empty_packet = false;  ///< URB_ZERO_PACKET: ends a multiple of the packet size
  std::array<std::uint8_t, 8> setup{};
  std::size_t length = 0;           ///< bytes wanted, or to be sent
  std::vector<std::uint8_t> bytes;  ///< to the host: filled; from it: what to send
  std::size_t sent = 0;
  enum class Stage : std::uint8_t { setup, data, status } stage = Stage::setup;
};

/// Linux error numbers as a URB's status tells them.
namespace urb_status {
inline constexpr std::int32_t ok = 0;
inline constexpr std::int32_t stalled = -32;         ///< EPIPE
inline constexpr std::int32_t protocol_error = -71;  ///< EPROTO
inline constexpr std::int32_t overflow = -75;        ///< EOVERFLOW
inline constexpr std::int32_t unlinked = -104;       ///< ECONNRESET
}  // namespace urb_status

class Bus {
 public:
  /// Called for each transfer that has ended. `transferred` bytes, of which those to the host are
  /// in `urb.bytes`.
  using Done = std::function<void(const Urb& urb, std::int32_t status, std::size_t transferred)>;

  Bus(UsbFunction& function, Done done) : function_(&function), done_(std::move(done)) {}

  void submit(Urb urb) { waiting_.push_back(std::move(urb)); }
  /// Takes a transfer back; false when it has ended already.
  bool unlink(std::uint32_t number);
  /// Lets transfers go on until every one of them is answered with NAK. True when any moved.
  bool run();
  bool idle() const { return waiting_.empty(); }

 private:
  enum class Step : std::uint8_t { waits, moved, ended };
  Step advance(Urb& urb);
  Step advance_control(Urb& urb);
  Step read(Urb& urb);
  Step write(Urb& urb);
  Step end(const Urb& urb, std::int32_t status, std::size_t transferred);
  Step fail(const Urb& urb, Handshake answer, std::size_t transferred);

  UsbFunction* function_;
  Done done_;
  std::list<Urb> waiting_;
};

}  // namespace umov::usbip
