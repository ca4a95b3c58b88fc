// How a register is reached: memory-mapped words and named bit fields.
#pragma once

#include <cstdint>

namespace umov::boards::stm32f407 {

/// A 32-bit register; every access is one load or store.
using Register = volatile std::uint32_t;

/// The registers of a block at `base`.
template <class Block>
Block& at(std::uintptr_t base) {
  return *reinterpret_cast<Block*>(base);
}

/// Read, change and write back. Not atomic: what interrupts share needs a CriticalSection.
inline void set_bits(Register& r, std::uint32_t bits) {
  r = r | bits;
}
inline void clear_bits(Register& r, std::uint32_t bits) {
  r = r & ~bits;
}
inline void change_bits(Register& r, std::uint32_t mask, std::uint32_t bits) {
  r = (r & ~mask) | bits;
}

constexpr std::uint32_t bit(unsigned number) {
  return 1u << number;
}

}  // namespace umov::boards::stm32f407
