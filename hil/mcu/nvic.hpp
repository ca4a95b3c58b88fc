// Interrupt controller and system control block (ARMv7-M B1.5, B3.2, B3.4).
#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "hil/mcu/peripheral.hpp"

namespace umov::mcu {

/// Exceptions are numbered as the processor does: 3 hard fault, 15 SysTick, 16 + n interrupt n.
class Nvic {
 public:
  static constexpr int interrupt_count = 82;
  static constexpr int exception_count = 16 + interrupt_count;
  static constexpr int systick_exception = 15;
  /// Four bits of priority are implemented, in the upper half of their byte.
  static constexpr int lowest_priority = 256;

  /// Level of an interrupt request; a rising one makes it pending, one still high when its handler
  /// returns makes it pending again.
  void set_line(int irq, bool level);
  void pend(int exception);

  /// What the processor masks.
  struct Masks {
    bool primask = false;
    bool faultmask = false;
    std::uint32_t basepri = 0;
  };
  /// The pending exception that would be taken now, or 0.
  int to_take(const Masks& masks) const;
  /// Whether a sleeping processor wakes: like to_take, but PRIMASK does not hold it.
  bool wakes(const Masks& masks) const;
  /// The processor enters `exception`.
  void enter(int exception);
  /// It returns from it: the innermost active one, or the call is refused (umov::Error).
  void leave(int exception);
  /// The exception being handled, 0 in thread mode.
  int active() const { return active_.empty() ? 0 : active_.back(); }
  std::size_t nesting() const { return active_.size(); }

  /// Whether anything has changed since this was last asked that decides what is taken.
  bool take_change() { return std::exchange(changed_, false); }

  std::uint32_t vector_table() const { return vtor_; }
  /// Set by AIRCR: the program asked for a reset.
  bool reset_requested() const { return reset_requested_; }

  /// System control space, offset from 0xE000E000, SysTick's registers excepted. `size` 1, 2 or 4.
  std::uint32_t read(std::uint32_t offset, unsigned size);
  void write(std::uint32_t offset, unsigned size, std::uint32_t value);

 private:
  int priority(int exception) const;
  int running_priority() const;
  int best_pending() const;
  std::uint32_t read_word(std::uint32_t offset) const;
  void write_word(std::uint32_t offset, std::uint32_t value);

  std::array<bool, exception_count> pending_{};
  std::array<bool, exception_count> enabled_{};
  std::array<bool, exception_count> line_{};
  std::array<std::uint8_t, exception_count> priority_{};
  std::vector<int> active_;  // innermost last
  std::uint32_t vtor_ = 0;
  std::uint32_t scr_ = 0;
  std::uint32_t ccr_ = 0x200;  // stack aligned to 8 at exceptions
  bool reset_requested_ = false;
  bool changed_ = false;
};

}  // namespace umov::mcu
