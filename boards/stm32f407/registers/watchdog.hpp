// Independent watchdog (RM0090 21.4) and power control (5.4).
#pragma once

#include "boards/stm32f407/registers/access.hpp"
#include "boards/stm32f407/registers/memory_map.hpp"

namespace umov::boards::stm32f407 {

struct IwdgRegisters {
  Register KR, PR, RLR, SR;
};
inline IwdgRegisters& iwdg() {
  return at<IwdgRegisters>(memory_map::iwdg);
}

namespace iwdg_keys {
inline constexpr std::uint32_t START = 0xCCCC, UNLOCK = 0x5555, RELOAD = 0xAAAA;
}

struct PwrRegisters {
  Register CR, CSR;
};
inline PwrRegisters& pwr() {
  return at<PwrRegisters>(memory_map::pwr);
}
namespace pwr_bits {
inline constexpr std::uint32_t VOS_SCALE_1 = bit(14);
/// CR: the voltage detector at its sixth level, 2.84 V falling (2.65 to 2.92) and 2.93 V rising:
/// boards that feed the chip through a diode run at 2.95 V. CSR: below it.
inline constexpr std::uint32_t PVDE = bit(4), PLS_2V84 = 5u << 5, PVDO = bit(2);
}  // namespace pwr_bits

}  // namespace umov::boards::stm32f407
