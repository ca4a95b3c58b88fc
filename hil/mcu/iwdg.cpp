#include "hil/mcu/iwdg.hpp"

#include <algorithm>
#include <utility>

namespace umov::mcu {
namespace {

constexpr Time lsi_cycle = time_per_second / 32'000;

}  // namespace

Iwdg::Iwdg(Scheduler& scheduler, Pulse on_timeout)
    : scheduler_(&scheduler), slot_(scheduler.add(std::move(on_timeout))) {}

void Iwdg::reload() {
  if (!running_) return;
  const Time count = lsi_cycle << (2 + std::min(prescaler_, 6u));
  scheduler_->set(slot_, scheduler_->now() + (reload_ + 1) * count);
}

std::uint32_t Iwdg::read(std::uint32_t offset) {
  switch (offset) {
    case 0x00:
      return 0;
    case 0x04:
      return prescaler_;
    case 0x08:
      return reload_;
    case 0x0C:
      return 0;  // new values are taken over at once
    default:
      refuse_register("IWDG", offset);
  }
}

void Iwdg::write(std::uint32_t offset, std::uint32_t value) {
  switch (offset) {
    case 0x00:
      open_ = value == 0x5555;
      if (value == 0xCCCC) running_ = true;
      if (value == 0xCCCC || value == 0xAAAA) reload();
      return;
    case 0x04:
      if (open_) prescaler_ = value & 7u;
      return;
    case 0x08:
      if (open_) reload_ = value & 0xFFFu;
      return;
    default:
      refuse_register("IWDG", offset);
  }
}

}  // namespace umov::mcu
