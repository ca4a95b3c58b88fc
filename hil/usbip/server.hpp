// Devices on virtual cables: served to any machine by USB/IP (`usbip attach -r HOST -b 1-1`), or
// plugged straight into this machine's kernel.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "hil/usbip/exported_device.hpp"
#include "host/net/socket.hpp"

namespace umov::usbip {

/// Not thread-safe; nothing but `wait` blocks.
class Server {
 public:
  /// Called when a device has been plugged in or unplugged.
  using OnPlug = std::function<void(const std::string& bus_id, bool plugged)>;

  explicit Server(std::vector<ExportedDevice> devices, OnPlug on_plug = {});
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  /// Listens for USB/IP clients; port 0 takes a free one. Returns the port. Throws umov::Error when
  /// it can't.
  std::uint16_t listen(std::uint16_t port, const std::string& address = "127.0.0.1");
  /// The device of that bus id has become another one. It must not be plugged in.
  void replace(ExportedDevice device);
  /// A client that has connected some other way; not blocking.
  void take_connection(net::Socket client);
  /// Plugs a device into this machine's kernel; see attach_to_kernel().
  void plug_into_kernel(const std::string& bus_id);
  bool plugged(const std::string& bus_id) const;
  /// Pulls the plug.
  void unplug(const std::string& bus_id);

  /// Waits until a host wants something, or `timeout`.
  void wait(std::chrono::microseconds timeout);
  /// Does what can be done now; true when anything happened.
  bool service();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace umov::usbip
