#include "hil/mcu/timer.hpp"

#include <algorithm>
#include <utility>

namespace umov::mcu {
namespace {

constexpr std::uint32_t cr1 = 0x00, cr2 = 0x04, dier = 0x0C, sr = 0x10, egr = 0x14, ccmr1 = 0x18,
                        ccmr2 = 0x1C, ccer = 0x20, cnt = 0x24, psc = 0x28, arr = 0x2C, ccr1 = 0x34,
                        ccr4 = 0x40;
constexpr std::uint32_t count_enable = 1, update_by_overflow_only = 4;

// OCxM
constexpr unsigned high_on_match = 1, low_on_match = 2, toggle = 3, force_low = 4, force_high = 5;

}  // namespace

Timer::Timer(const char* name, std::uint32_t top, Scheduler& scheduler, std::function<Time()> cycle,
             Wires wires)
    : name_(name),
      top_(top),
      scheduler_(&scheduler),
      cycle_(std::move(cycle)),
      wires_(std::move(wires)),
      slot_(scheduler.add([this] { happen(); })),
      arr_(top) {}

std::uint32_t Timer::count() const {
  if (!running()) return base_count_;
  const std::uint64_t period = std::uint64_t{arr_} + 1;
  const std::uint64_t gone = (scheduler_->now() - base_time_) / tick_;
  return static_cast<std::uint32_t>((base_count_ + gone) % period);
}

void Timer::set_count(std::uint32_t value) {
  base_count_ = value;
  base_time_ = scheduler_->now();
}

/// Sets the event of the next match or overflow.
void Timer::plan() {
  if (!running()) return scheduler_->clear(slot_);
  const std::uint64_t here = base_count_;
  std::uint64_t ticks = std::uint64_t{arr_} + 1 - std::min<std::uint64_t>(here, arr_);
  for (const Channel& channel : channels_) {
    if (!channel.captures && channel.compare > here && channel.compare <= arr_)
      ticks = std::min(ticks, channel.compare - here);
  }
  scheduler_->set(slot_, base_time_ + ticks * tick_);
}

void Timer::happen() {
  const std::uint32_t now = count();
  set_count(now);
  if (now == 0) update();
  for (int channel = 1; channel <= 4; ++channel) {
    const Channel& c = channels_[static_cast<std::size_t>(channel - 1)];
    if (!c.captures && c.compare == now) match(channel);
  }
  plan();
  tell_interrupt();
}

void Timer::match(int channel) {
  Channel& c = channels_[static_cast<std::size_t>(channel - 1)];
  if (c.mode == high_on_match) c.reference = true;
  if (c.mode == low_on_match) c.reference = false;
  if (c.mode == toggle) c.reference = !c.reference;
  show_outputs();
  sr_ |= 1u << channel;
  if ((dier_ >> (8 + channel) & 1u) != 0 && wires_.dma_request) wires_.dma_request(channel);
}

void Timer::rise(int channel) {
  Channel& c = channels_[static_cast<std::size_t>(channel - 1)];
  if (!c.captures || (ccer_ >> 4 * (channel - 1) & 1u) == 0) return;
  if ((sr_ >> channel & 1u) != 0) sr_ |= 1u << (8 + channel);
  c.compare = count();
  sr_ |= 1u << channel;
  tell_interrupt();
}

void Timer::update() {
  if (prescaler_ != prescaler_next_) {
    prescaler_ = prescaler_next_;
    tick_ = cycle_() * (Time{prescaler_} + 1);
  }
  sr_ |= 1u;
  if ((cr2_ >> 4 & 7u) == 2 && wires_.trigger) wires_.trigger();
}

void Timer::show_outputs() {
  for (int channel = 1; channel <= 4; ++channel) {
    Channel& c = channels_[static_cast<std::size_t>(channel - 1)];
    const bool enabled = (ccer_ >> 4 * (channel - 1) & 1u) != 0;
    const bool level = enabled && c.reference;
    if (level == c.shown) continue;
    c.shown = level;
    if (wires_.on_output) wires_.on_output(channel, level);
  }
}

void Timer::change_modes() {
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    const std::uint32_t field = ccmr_[i / 2] >> 8 * (i % 2) & 0xFFu;
    Channel& c = channels_[i];
    c.captures = (field & 3u) == 1;
    if (c.captures && field != 1)
      refuse_setting(name_, "CCMR (filtered or divided capture)", field);
    if ((field & 3u) > 1) refuse_setting(name_, "CCMR (capture of another input)", field);
    if (c.captures) continue;
    c.mode = field >> 4 & 7u;
    if (c.mode > force_high) refuse_setting(name_, "CCMR (pulse-width modulation)", field);
    if (c.mode == force_low) c.reference = false;
    if (c.mode == force_high) c.reference = true;
  }
  show_outputs();
}

std::uint32_t Timer::read(std::uint32_t offset) {
  if (offset >= ccr1 && offset <= ccr4) {
    const std::uint32_t i = (offset - ccr1) / 4;
    if (channels_[i].captures) {
      sr_ &= ~(2u << i);
      tell_interrupt();
    }
    return channels_[i].compare;
  }
  switch (offset) {
    case cr1:
      return cr1_;
    case cr2:
      return cr2_;
    case dier:
      return dier_;
    case sr:
      return sr_;
    case egr:
      return 0;
    case ccmr1:
    case ccmr2:
      return ccmr_[(offset - ccmr1) / 4];
    case ccer:
      return ccer_;
    case cnt:
      return count();
    case psc:
      return prescaler_next_;
    case arr:
      return arr_;
    default:
      refuse_register(name_, offset);
  }
}

void Timer::write(std::uint32_t offset, std::uint32_t value) {
  const std::uint32_t before = count();
  if (offset >= ccr1 && offset <= ccr4) {
    channels_[(offset - ccr1) / 4].compare = value & top_;
  } else {
    switch (offset) {
      case cr1:
        if ((value & ~(count_enable | update_by_overflow_only)) != 0)
          refuse_setting(name_, "CR1", value);
        if (!running()) tick_ = cycle_() * (Time{prescaler_} + 1);
        // The part of a tick that has gone is kept while it runs on.
        if (running() != ((value & count_enable) != 0)) set_count(before);
        cr1_ = value;
        break;
      case cr2:
        if ((value & ~0x70u) != 0 || ((value >> 4 & 7u) != 0 && (value >> 4 & 7u) != 2))
          refuse_setting(name_, "CR2", value);
        cr2_ = value;
        break;
      case dier:
        if ((value & ~0x1E1Fu) != 0) refuse_setting(name_, "DIER", value);
        dier_ = value;
        break;
      case sr:
        sr_ &= value;
        break;
      case egr:
        if ((value & 1u) != 0) {
          set_count(0);
          const std::uint32_t flags = sr_;
          update();
          if ((cr1_ & update_by_overflow_only) != 0) sr_ = flags;
        }
        for (int channel = 1; channel <= 4; ++channel) {
          // A software event sets the flag and asks for DMA; the output stays.
          if ((value >> channel & 1u) == 0) continue;
          sr_ |= 1u << channel;
          if ((dier_ >> (8 + channel) & 1u) != 0 && wires_.dma_request) wires_.dma_request(channel);
        }
        break;
      case ccmr1:
      case ccmr2:
        ccmr_[(offset - ccmr1) / 4] = value;
        change_modes();
        break;
      case ccer:
        if ((value & ~0x1111u) != 0) refuse_setting(name_, "CCER", value);
        ccer_ = value;
        show_outputs();
        break;
      case cnt:
        set_count(value & top_);
        break;
      case psc:
        prescaler_next_ = value & 0xFFFF;
        break;
      case arr:
        set_count(before);
        arr_ = value & top_;
        break;
      default:
        refuse_register(name_, offset);
    }
  }
  if (running()) {
    // Events are planned from the last whole tick, so that the phase of the ticks stays.
    const std::uint64_t gone = (scheduler_->now() - base_time_) / tick_;
    base_count_ = count();
    base_time_ += gone * tick_;
  }
  plan();
  tell_interrupt();
}

}  // namespace umov::mcu
