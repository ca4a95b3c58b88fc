// BOOT0 and NRST of the emulated board, for a GPIO adapter.
#pragma once

#include <utility>

#include "hil/mcu/stm32f407.hpp"
#include "host/cli/emulator/bench_lines.hpp"

namespace umov::emulator {

class McuPins final : public BoardPins {
 public:
  /// `chip` must outlive it.
  explicit McuPins(mcu::Stm32f407& chip) : chip_(&chip) {}

  void set_boot0(bool high) override { chip_->set_boot0(high); }
  void set_nrst(bool high) override {
    chip_->set_nrst(high);
    if (!high) was_reset_ = true;
  }
  /// Whether NRST went low since this was last asked: the board's USB device has gone with it.
  bool take_reset() { return std::exchange(was_reset_, false); }

 private:
  mcu::Stm32f407* chip_;
  bool was_reset_ = false;
};

}  // namespace umov::emulator
