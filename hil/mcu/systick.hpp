// The processor's own tick timer (ARMv7-M B3.3), on the core's clock.
#pragma once

#include "hil/mcu/peripheral.hpp"

namespace umov::mcu {

class SysTick {
 public:
  /// `cycle` is the duration of a core cycle, read when the timer is set.
  SysTick(Scheduler& scheduler, std::function<Time()> cycle, Pulse on_tick);

  std::uint32_t read(std::uint32_t offset);
  void write(std::uint32_t offset, std::uint32_t value);

 private:
  void restart();
  void expire();

  Scheduler* scheduler_;
  std::function<Time()> cycle_;
  Pulse on_tick_;
  Scheduler::Slot slot_;
  std::uint32_t control_ = 0;
  std::uint32_t reload_ = 0;
  bool counted_ = false;
  Time expires_ = never;
};

}  // namespace umov::mcu
