// GDB's remote protocol for the emulated chip: what a debugger asks, answered.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "hil/mcu/stm32f407.hpp"

namespace umov::mcu {

/// Packets as GDB documents them ("Remote Serial Protocol"): registers, memory, breakpoints, single
/// steps, continue and interrupt. No watchpoints and no writing of flash. Not thread-safe.
class GdbStub {
 public:
  /// `chip` must outlive it; a debugger that connects halts it.
  explicit GdbStub(Stm32f407& chip) : chip_(&chip) {}

  /// Bytes from the debugger, in pieces of any size; what is to be sent is appended to `output`.
  void take(std::string_view bytes, std::string& output);
  /// To be called when the chip has run: tells the debugger when it has stopped.
  void look_at_chip(std::string& output);
  /// The debugger has come, or has gone: then breakpoints are taken away and the program goes on.
  void connected();
  void disconnected();

 private:
  std::string answer(std::string_view packet);
  std::string registers() const;
  std::string read_register(std::string_view arguments) const;
  std::string write_register(std::string_view arguments);
  std::string read_memory(std::string_view arguments) const;
  std::string write_memory(std::string_view arguments);
  std::string change_breakpoint(std::string_view packet);
  std::string features(std::string_view arguments) const;
  void go_on();

  Stm32f407* chip_;
  std::string input_;
  bool running_ = true;
};

}  // namespace umov::mcu
