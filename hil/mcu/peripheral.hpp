// What every block of the chip is to the bus, and what it may use of the chip.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "hil/mcu/scheduler.hpp"

namespace umov::mcu {

/// A block of registers. Accesses are 32 bits wide, the offset is a multiple of 4; the moment is
/// the scheduler's now(). A register the model does not have is refused by throwing
/// umov::Error: the emulation stops there and says so.
class Peripheral {
 public:
  virtual ~Peripheral() = default;
  virtual std::uint32_t read(std::uint32_t offset) = 0;
  virtual void write(std::uint32_t offset, std::uint32_t value) = 0;
};

/// "0x40012000"; eight digits.
std::string hexadecimal(std::uint32_t value);

/// Throws umov::Error: `block` has no register at `offset` in this model.
[[noreturn]] void refuse_register(const char* block, std::uint32_t offset);
/// Throws umov::Error: the value written asks for something this model does not do.
[[noreturn]] void refuse_setting(const char* block, const char* reg, std::uint32_t value);

/// A line from a block to the interrupt controller: level of interrupt request `irq`.
using InterruptLine = std::function<void(bool level)>;
/// A pulse from one block to another (trigger, DMA request).
using Pulse = std::function<void()>;

}  // namespace umov::mcu
