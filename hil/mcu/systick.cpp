#include "hil/mcu/systick.hpp"

namespace umov::mcu {
namespace {

constexpr std::uint32_t csr = 0, rvr = 4, cvr = 8, calib = 12;
constexpr std::uint32_t enable = 1, interrupt = 2, core_clock = 4, count_flag = 1u << 16;

}  // namespace

SysTick::SysTick(Scheduler& scheduler, std::function<Time()> cycle, Pulse on_tick)
    : scheduler_(&scheduler),
      cycle_(std::move(cycle)),
      on_tick_(std::move(on_tick)),
      slot_(scheduler.add([this] { expire(); })) {}

void SysTick::restart() {
  expires_ = (control_ & enable) != 0 && reload_ != 0
                 ? scheduler_->now() + (Time{reload_} + 1) * cycle_()
                 : never;
  scheduler_->set(slot_, expires_);
}

void SysTick::expire() {
  counted_ = true;
  restart();
  if ((control_ & interrupt) != 0) on_tick_();
}

std::uint32_t SysTick::read(std::uint32_t offset) {
  switch (offset) {
    case csr: {
      const std::uint32_t value = control_ | (counted_ ? count_flag : 0u);
      counted_ = false;
      return value;
    }
    case rvr:
      return reload_;
    case cvr:
      return expires_ == never
                 ? 0
                 : static_cast<std::uint32_t>((expires_ - scheduler_->now()) / cycle_());
    case calib:
      return 0;
    default:
      refuse_register("SysTick", offset);
  }
}

void SysTick::write(std::uint32_t offset, std::uint32_t value) {
  switch (offset) {
    case csr: {
      if ((value & enable) != 0 && (value & core_clock) == 0)
        refuse_setting("SysTick", "CSR", value);
      const bool starts = (value & ~control_ & enable) != 0;
      control_ = value & (enable | interrupt | core_clock);
      if (starts || (control_ & enable) == 0) restart();
      return;
    }
    case rvr:
      reload_ = value & 0xFF'FFFF;
      return;
    case cvr:
      counted_ = false;
      restart();
      return;
    default:
      refuse_register("SysTick", offset);
  }
}

}  // namespace umov::mcu
