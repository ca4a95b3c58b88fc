// A debugger's way to the emulated chip, where one was asked for.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "hil/mcu/gdb/gdb_server.hpp"

namespace umov::emulator {

class DebuggerPort {
 public:
  /// Nothing without a port. `on_listening` may be empty.
  DebuggerPort(mcu::Stm32f407& chip, std::optional<std::uint16_t> port,
               const std::function<void(std::uint16_t)>& on_listening) {
    if (!port) return;
    server_.emplace(chip, *port);
    if (on_listening) on_listening(server_->port());
  }
  void service() {
    if (server_) server_->service();
  }

 private:
  std::optional<mcu::GdbServer> server_;
};

}  // namespace umov::emulator
