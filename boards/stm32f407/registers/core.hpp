// What the Cortex-M4 itself has: SysTick, NVIC, system control block (PM0214 4), and the masking of
// interrupts.
#pragma once

#include "boards/stm32f407/registers/access.hpp"
#include "boards/stm32f407/registers/memory_map.hpp"

namespace umov::boards::stm32f407 {

struct SysTickRegisters {
  Register CSR, RVR, CVR, CALIB;
};
inline SysTickRegisters& systick() {
  return at<SysTickRegisters>(memory_map::systick);
}
namespace systick_bits {
inline constexpr std::uint32_t ENABLE = bit(0), TICKINT = bit(1), CLKSOURCE = bit(2);
}

struct ScbRegisters {
  Register CPUID, ICSR, VTOR, AIRCR, SCR, CCR, SHPR[3], SHCSR;
};
inline ScbRegisters& scb() {
  return at<ScbRegisters>(memory_map::scb);
}

/// Interrupt numbers (RM0090 table 61).
enum class Irq : unsigned {
  pvd = 1,
  exti4 = 10,
  dma1_stream6 = 17,
  adc = 18,
  exti9_5 = 23,
  tim1_cc = 27,
  tim2 = 28,
  exti15_10 = 40,
  tim5 = 50,
  dma2_stream0 = 56,
  otg_fs = 67,
};

/// 0 (most urgent) to 15: the four bits the chip has.
inline void set_priority(Irq irq, unsigned priority) {
  const auto number = static_cast<unsigned>(irq);
  auto& byte = at<volatile std::uint8_t>(memory_map::nvic + 0x300 + number);
  byte = static_cast<std::uint8_t>(priority << 4);
}
inline void enable(Irq irq) {
  const auto number = static_cast<unsigned>(irq);
  at<Register>(memory_map::nvic + 4 * (number / 32)) = bit(number % 32);
}
inline void clear_pending(Irq irq) {
  const auto number = static_cast<unsigned>(irq);
  at<Register>(memory_map::nvic + 0x180 + 4 * (number / 32)) = bit(number % 32);
}
/// Priority of SysTick, exception 15.
inline void set_systick_priority(unsigned priority) {
  change_bits(scb().SHPR[2], 0xFFu << 24, priority << 28);
}

/// Keeps all interrupts out as long as it lives; may be nested.
class CriticalSection {
 public:
  CriticalSection() { asm volatile("mrs %0, primask\n\tcpsid i" : "=r"(primask_) : : "memory"); }
  ~CriticalSection() { asm volatile("msr primask, %0" : : "r"(primask_) : "memory"); }
  CriticalSection(const CriticalSection&) = delete;
  CriticalSection& operator=(const CriticalSection&) = delete;

 private:
  std::uint32_t primask_;
};

}  // namespace umov::boards::stm32f407
