// The emulated instrument with the controller as hardware: the image that is flashed, on the
// emulated STM32F407, wired to the plant.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "hil/mcu/board/mcu_board.hpp"
#include "hil/plant/plant.hpp"
#include "host/cli/emulator/emulated_instrument.hpp"
#include "host/instrument/transport.hpp"

namespace umov::emulator {

/// Board and plant together; not thread-safe. Virtual time is instructions: slower than the native
/// board by some ten times.
class McuInstrument {
 public:
  /// `board.image` is the ELF file. Throws umov::Error for what BenchOptions or the image have
  /// wrong.
  McuInstrument(const BenchOptions& options, mcu::McuBoardOptions board);

  mcu::McuBoard& board() { return *board_; }
  plant::Plant& plant() { return *plant_; }

 private:
  std::unique_ptr<plant::Plant> plant_;
  std::unique_ptr<mcu::Bench> wiring_;
  std::unique_ptr<mcu::McuBoard> board_;
};

/// The serial line of one that lives on when the connection ends; one at a time. Virtual time
/// passes while the host waits for bytes.
std::unique_ptr<instrument::Transport> connect_serial(std::shared_ptr<McuInstrument> instrument);

}  // namespace umov::emulator
