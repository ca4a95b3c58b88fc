#include "hil/mcu/nvic.hpp"

#include <algorithm>

#include "host/errors/error.hpp"

namespace umov::mcu {
namespace {

constexpr std::uint32_t set_enable = 0x100, clear_enable = 0x180, set_pending = 0x200,
                        clear_pending = 0x280, active_bits = 0x300, priorities = 0x400;
constexpr std::uint32_t cpuid = 0xD00, icsr = 0xD04, vtor = 0xD08, aircr = 0xD0C, scr = 0xD10,
                        ccr = 0xD14, shpr1 = 0xD18, cpacr = 0xD88;
constexpr std::uint32_t bank_bytes = 4 * ((Nvic::interrupt_count + 31) / 32);

bool within(std::uint32_t offset, std::uint32_t begin, std::uint32_t bytes) {
  return offset >= begin && offset < begin + bytes;
}

}  // namespace

int Nvic::priority(int exception) const {
  switch (exception) {
    case 2:
      return -2;
    case 3:
      return -1;
    default:
      return priority_[static_cast<std::size_t>(exception)];
  }
}

int Nvic::running_priority() const {
  int urgent = lowest_priority;
  for (const int exception : active_) urgent = std::min(urgent, priority(exception));
  return urgent;
}

int Nvic::best_pending() const {
  int best = 0;
  for (int e = 2; e < exception_count; ++e) {
    const auto i = static_cast<std::size_t>(e);
    if (!pending_[i] || (e >= 16 && !enabled_[i])) continue;
    if (best == 0 || priority(e) < priority(best)) best = e;  // equal: the lower number
  }
  return best;
}

int Nvic::to_take(const Masks& masks) const {
  const int best = best_pending();
  if (best == 0) return 0;
  int bar = running_priority();
  if (masks.basepri != 0) bar = std::min(bar, static_cast<int>(masks.basepri & 0xF0));
  if (masks.primask) bar = std::min(bar, 0);
  if (masks.faultmask) bar = std::min(bar, -1);
  return priority(best) < bar ? best : 0;
}

bool Nvic::wakes(const Masks& masks) const {
  Masks without = masks;
  without.primask = false;
  return to_take(without) != 0;
}

void Nvic::set_line(int irq, bool level) {
  const auto i = static_cast<std::size_t>(16 + irq);
  if (level && !line_[i]) pending_[i] = changed_ = true;
  line_[i] = level;
}

void Nvic::pend(int exception) {
  pending_[static_cast<std::size_t>(exception)] = changed_ = true;
}

void Nvic::enter(int exception) {
  pending_[static_cast<std::size_t>(exception)] = false;
  active_.push_back(exception);
}

void Nvic::leave(int exception) {
  if (active_.empty() || active_.back() != exception) {
    throw Error(
        "the program returns from exception " + std::to_string(exception) + " and is not in it",
        "look at what changed the stack or the link register of the handler");
  }
  active_.pop_back();
  const auto i = static_cast<std::size_t>(exception);
  if (line_[i]) pending_[i] = true;
}

std::uint32_t Nvic::read(std::uint32_t offset, unsigned size) {
  const std::uint32_t word = read_word(offset & ~3u);
  const unsigned shift = 8 * (offset & 3u);
  return size == 4 ? word : (word >> shift) & ((1u << 8 * size) - 1);
}

void Nvic::write(std::uint32_t offset, unsigned size, std::uint32_t value) {
  if (size == 4) return write_word(offset, value);
  const bool by_bytes = within(offset, priorities, interrupt_count) || within(offset, shpr1, 12);
  if (!by_bytes) refuse_setting("NVIC", "an access narrower than a word", offset);
  const unsigned shift = 8 * (offset & 3u);
  const std::uint32_t mask = ((1u << 8 * size) - 1) << shift;
  const std::uint32_t word = read_word(offset & ~3u);
  write_word(offset & ~3u, (word & ~mask) | ((value << shift) & mask));
}

std::uint32_t Nvic::read_word(std::uint32_t offset) const {
  const auto bits = [&](const auto& of, std::uint32_t begin) {
    std::uint32_t word = 0;
    for (std::uint32_t b = 0; b < 32; ++b) {
      const std::size_t i = 16 + 8 * (offset - begin) + b;
      if (i < exception_count && of[i]) word |= 1u << b;
    }
    return word;
  };
  const auto bytes = [&](std::size_t first) {
    std::uint32_t word = 0;
    for (std::size_t b = 0; b < 4 && first + b < exception_count; ++b) {
      word |= static_cast<std::uint32_t>(priority_[first + b]) << 8 * b;
    }
    return word;
  };
  if (within(offset, set_enable, bank_bytes)) return bits(enabled_, set_enable);
  if (within(offset, clear_enable, bank_bytes)) return bits(enabled_, clear_enable);
  if (within(offset, set_pending, bank_bytes)) return bits(pending_, set_pending);
  if (within(offset, clear_pending, bank_bytes)) return bits(pending_, clear_pending);
  if (within(offset, active_bits, bank_bytes)) {
    std::array<bool, exception_count> is_active{};
    for (const int e : active_) is_active[static_cast<std::size_t>(e)] = true;
    return bits(is_active, active_bits);
  }
  if (within(offset, priorities, interrupt_count)) return bytes(16 + offset - priorities);
  if (within(offset, shpr1, 12)) return bytes(4 + offset - shpr1);
  switch (offset) {
    case cpuid:
      return 0x410FC241;  // Cortex-M4 r0p1
    case icsr: {
      const auto pending = static_cast<std::uint32_t>(best_pending());
      return static_cast<std::uint32_t>(active()) | pending << 12 |
             (pending_[systick_exception] ? 1u << 26 : 0u);
    }
    case vtor:
      return vtor_;
    case aircr:
      return 0xFA05'0000;
    case scr:
      return scr_;
    case ccr:
      return ccr_;
    case cpacr:
      return 0;
    default:
      refuse_register("the system control space", offset);
  }
}

void Nvic::write_word(std::uint32_t offset, std::uint32_t value) {
  changed_ = true;
  const auto change = [&](auto& of, std::uint32_t begin, bool to) {
    for (std::uint32_t b = 0; b < 32; ++b) {
      const std::size_t i = 16 + 8 * (offset - begin) + b;
      if (i < exception_count && (value >> b & 1u) != 0) of[i] = to;
    }
  };
  const auto bytes = [&](std::size_t first) {
    for (std::size_t b = 0; b < 4 && first + b < exception_count; ++b) {
      priority_[first + b] = static_cast<std::uint8_t>(value >> 8 * b & 0xF0);
    }
  };
  if (within(offset, set_enable, bank_bytes)) return change(enabled_, set_enable, true);
  if (within(offset, clear_enable, bank_bytes)) return change(enabled_, clear_enable, false);
  if (within(offset, set_pending, bank_bytes)) return change(pending_, set_pending, true);
  if (within(offset, clear_pending, bank_bytes)) return change(pending_, clear_pending, false);
  if (within(offset, priorities, interrupt_count)) return bytes(16 + offset - priorities);
  if (within(offset, shpr1, 12)) return bytes(4 + offset - shpr1);
  switch (offset) {
    case icsr:
      if ((value >> 26 & 1u) != 0) pending_[systick_exception] = true;
      if ((value >> 25 & 1u) != 0) pending_[systick_exception] = false;
      return;
    case vtor:
      vtor_ = value & ~0x1FFu;
      return;
    case aircr:
      // All four bits are for preemption in groups 0 to 3.
      if (value >> 16 != 0x05FA) return;
      if ((value >> 8 & 7u) > 3) refuse_setting("the system control block", "AIRCR", value);
      reset_requested_ = (value & 4u) != 0;
      return;
    case scr:
      scr_ = value;
      return;
    case ccr:
      ccr_ = value;
      return;
    case cpacr:
      if (value != 0) refuse_setting("the system control block", "CPACR", value);
      return;
    default:
      refuse_register("the system control space", offset);
  }
}

}  // namespace umov::mcu
