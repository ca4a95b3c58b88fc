// A USB cable over a stream socket: the kernel's virtual host controller at one end, a device at
// the other.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "hil/usbip/bus.hpp"
#include "hil/usbip/usb_function.hpp"
#include "host/net/socket.hpp"

namespace umov::usbip {

class Cable {
 public:
  /// Plugs the device in: it is reset. `socket` has carried the USB/IP import already (or is one
  /// end of a pair whose other one the kernel was given). The device must outlive the cable.
  Cable(net::Socket socket, UsbFunction& function);
  Cable(const Cable&) = delete;
  Cable& operator=(const Cable&) = delete;

  /// To wait for with poll: readable always, writable when `wants_to_write`.
  int descriptor() const { return socket_.descriptor(); }
  bool wants_to_write() const { return written_ < output_.size(); }
  /// Takes what the host has sent, moves transfers, sends what has ended. Does not wait. True when
  /// anything happened.
  bool service();
  /// The host has unplugged the device, or spoke nonsense.
  bool broken() const { return broken_; }

 private:
  bool read_socket();
  bool take_commands();
  void flush();
  void finish(const Urb& urb, std::int32_t status, std::size_t transferred);

  net::Socket socket_;
  Bus bus_;
  std::vector<std::uint8_t> input_;
  std::size_t taken_ = 0;
  std::vector<std::uint8_t> output_;
  std::size_t written_ = 0;
  bool broken_ = false;
};

}  // namespace umov::usbip
