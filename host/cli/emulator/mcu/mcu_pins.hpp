// BOOT0 and NRST of the emulated board, for a GPIO adapter.
#pragma once

#include "hil/mcu/stm32f407.hpp"
#include "host/cli/emulator/bench_lines.hpp"

namespace umov::emulator {

class McuPins final : public BoardPins {
 public:
  /// `chip` must outlive it.
  explicit McuPins(mcu::Stm32f407& chip) : chip_(&chip) {}

  void set_boot0(bool high) override { chip_->set_boot0(high); }
  void set_nrst(bool high) override { chip_->set_nrst(high); }

 private:
  mcu::Stm32f407* chip_;
};

}  // namespace umov::emulator
