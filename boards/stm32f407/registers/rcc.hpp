// Reset and clock control (RM0090 7.3).
#pragma once

#include "boards/stm32f407/registers/access.hpp"
#include "boards/stm32f407/registers/memory_map.hpp"

namespace umov::boards::stm32f407 {

struct RccRegisters {
  Register CR, PLLCFGR, CFGR, CIR;
  Register AHB1RSTR, AHB2RSTR, AHB3RSTR, reserved0;
  Register APB1RSTR, APB2RSTR, reserved1[2];
  Register AHB1ENR, AHB2ENR, AHB3ENR, reserved2;
  Register APB1ENR, APB2ENR, reserved3[2];
  Register AHB1LPENR, AHB2LPENR, AHB3LPENR, reserved4;
  Register APB1LPENR, APB2LPENR, reserved5[2];
  Register BDCR, CSR, reserved6[2];
  Register SSCGR, PLLI2SCFGR;
};
static_assert(sizeof(RccRegisters) == 0x88);

inline RccRegisters& rcc() {
  return at<RccRegisters>(memory_map::rcc);
}

namespace rcc_bits {
inline constexpr std::uint32_t HSEON = bit(16), HSERDY = bit(17), PLLON = bit(24), PLLRDY = bit(25);
inline constexpr std::uint32_t PLLSRC_HSE = bit(22);
inline constexpr std::uint32_t SW_PLL = 2, SWS_MASK = 3u << 2, SWS_PLL = 2u << 2;
inline constexpr std::uint32_t PPRE1_DIV4 = 5u << 10, PPRE2_DIV2 = 4u << 13;
// AHB1ENR
inline constexpr std::uint32_t GPIO_ALL = 0x1F, CCMDATARAMEN = bit(20), DMA1EN = bit(21),
                               DMA2EN = bit(22);
// AHB2ENR
inline constexpr std::uint32_t OTGFSEN = bit(7);
// APB1ENR
inline constexpr std::uint32_t TIM2EN = bit(0), TIM5EN = bit(3), USART2EN = bit(17),
                               PWREN = bit(28);
// APB2ENR
inline constexpr std::uint32_t TIM1EN = bit(0), TIM8EN = bit(1), ADC1EN = bit(8), ADC2EN = bit(9),
                               SYSCFGEN = bit(14);
// CSR
inline constexpr std::uint32_t RMVF = bit(24), BORRSTF = bit(25), PINRSTF = bit(26),
                               PORRSTF = bit(27), SFTRSTF = bit(28), IWDGRSTF = bit(29);
}  // namespace rcc_bits

}  // namespace umov::boards::stm32f407
