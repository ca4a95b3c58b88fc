// Independent watchdog (RM0090 21) on its own 32 kHz.
#pragma once

#include "hil/mcu/peripheral.hpp"

namespace umov::mcu {

class Iwdg : public Peripheral {
 public:
  Iwdg(Scheduler& scheduler, Pulse on_timeout);

  std::uint32_t read(std::uint32_t offset) override;
  void write(std::uint32_t offset, std::uint32_t value) override;

 private:
  void reload();

  Scheduler* scheduler_;
  Scheduler::Slot slot_;
  bool running_ = false, open_ = false;
  std::uint32_t prescaler_ = 0, reload_ = 0xFFF;
};

}  // namespace umov::mcu
