// The stub behind a TCP port: `target remote localhost:PORT`.
#pragma once

#include <cstdint>
#include <string>

#include "hil/mcu/gdb/gdb_stub.hpp"
#include "host/net/listener.hpp"

namespace umov::mcu {

/// One debugger at a time. Nothing blocks.
class GdbServer {
 public:
  /// Port 0 takes a free one. Throws umov::Error when it can't listen.
  GdbServer(Stm32f407& chip, std::uint16_t port, const std::string& address = "127.0.0.1");

  std::uint16_t port() const { return listener_.port(); }
  /// To be called between pieces of the chip's time, often: takes what the debugger says.
  void service();

 private:
  void receive();
  void drop();

  net::Listener listener_;
  net::Socket client_;
  GdbStub stub_;
  std::string output_;
};

}  // namespace umov::mcu
