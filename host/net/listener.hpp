// A TCP port of this machine that others may connect to.
#pragma once

#include <cstdint>
#include <string>

#include "host/net/socket.hpp"

namespace umov::net {

class Listener {
 public:
  Listener() = default;
  /// Port 0 takes a free one. Throws umov::Error with address, reason and remedy.
  Listener(std::uint16_t port, const std::string& address);

  std::uint16_t port() const { return port_; }
  /// To wait for with poll; -1 while it does not listen.
  int descriptor() const { return socket_.descriptor(); }
  /// The next client, not blocking and without Nagle's delay; empty when there is none.
  Socket accept() const;

 private:
  Socket socket_;
  std::uint16_t port_ = 0;
};

/// After a failed call: nothing to be had now, no fault.
bool would_block(int error_number);

}  // namespace umov::net
