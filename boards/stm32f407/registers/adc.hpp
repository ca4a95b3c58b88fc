// Analog-to-digital converters (RM0090 13.13).
#pragma once

#include "boards/stm32f407/registers/access.hpp"
#include "boards/stm32f407/registers/memory_map.hpp"

namespace umov::boards::stm32f407 {

struct AdcRegisters {
  Register SR, CR1, CR2, SMPR1, SMPR2, JOFR[4], HTR, LTR, SQR1, SQR2, SQR3, JSQR, JDR[4], DR;
};
static_assert(sizeof(AdcRegisters) == 0x50);
struct AdcCommonRegisters {
  Register CSR, CCR, CDR;
};

inline AdcRegisters& adc1() {
  return at<AdcRegisters>(memory_map::adc1);
}
inline AdcRegisters& adc2() {
  return at<AdcRegisters>(memory_map::adc2);
}
inline AdcCommonRegisters& adc_common() {
  return at<AdcCommonRegisters>(memory_map::adc_common);
}

namespace adc_bits {
inline constexpr std::uint32_t OVR = bit(5);                          // SR
inline constexpr std::uint32_t OVRIE = bit(26);                       // CR1
inline constexpr std::uint32_t ADON = bit(0);                         // CR2
inline constexpr std::uint32_t EXTSEL_TIM8_TRGO = 14u << 24;          // CR2
inline constexpr std::uint32_t EXTEN_RISING = 1u << 28;               // CR2
inline constexpr std::uint32_t MULTI_REGULAR_SIMULTANEOUS = 6;        // CCR
inline constexpr std::uint32_t DDS = bit(13), DMA_MODE_2 = 2u << 14;  // CCR
inline constexpr std::uint32_t ADCPRE_DIV4 = 1u << 16;                // CCR: 84 MHz / 4 = 21 MHz
}  // namespace adc_bits

}  // namespace umov::boards::stm32f407
