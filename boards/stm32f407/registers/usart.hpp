// USART (RM0090 30.6).
#pragma once

#include "boards/stm32f407/registers/access.hpp"
#include "boards/stm32f407/registers/memory_map.hpp"

namespace umov::boards::stm32f407 {

struct UsartRegisters {
  Register SR, DR, BRR, CR1, CR2, CR3, GTPR;
};

inline UsartRegisters& usart2() {
  return at<UsartRegisters>(memory_map::usart2);
}

namespace usart_bits {
inline constexpr std::uint32_t RE = bit(2), TE = bit(3), UE = bit(13);  // CR1
inline constexpr std::uint32_t DMAR = bit(6), DMAT = bit(7);            // CR3
}  // namespace usart_bits

}  // namespace umov::boards::stm32f407
