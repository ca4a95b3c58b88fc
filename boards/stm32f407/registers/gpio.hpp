// General-purpose I/O (RM0090 8.4), external interrupts (12.3) and their choice of port (9.2).
#pragma once

#include "boards/stm32f407/description.hpp"
#include "boards/stm32f407/registers/access.hpp"
#include "boards/stm32f407/registers/memory_map.hpp"

namespace umov::boards::stm32f407 {

struct GpioRegisters {
  Register MODER, OTYPER, OSPEEDR, PUPDR, IDR, ODR, BSRR, LCKR, AFR[2];
};
static_assert(sizeof(GpioRegisters) == 0x28);

constexpr std::uintptr_t gpio_base(Port port) {
  return memory_map::gpioa + static_cast<std::uintptr_t>(port) * memory_map::gpio_spacing;
}
inline GpioRegisters& gpio(Port port) {
  return at<GpioRegisters>(gpio_base(port));
}

struct ExtiRegisters {
  Register IMR, EMR, RTSR, FTSR, SWIER, PR;
};
inline ExtiRegisters& exti() {
  return at<ExtiRegisters>(memory_map::exti);
}

/// Line 16 is the output of the supply's voltage detector.
inline constexpr std::uint32_t supply_line = bit(16);

struct SyscfgRegisters {
  Register MEMRMP, PMC, EXTICR[4], reserved[2], CMPCR;
};
static_assert(sizeof(SyscfgRegisters) == 0x24);
inline SyscfgRegisters& syscfg() {
  return at<SyscfgRegisters>(memory_map::syscfg);
}

}  // namespace umov::boards::stm32f407
