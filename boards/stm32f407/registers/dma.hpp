// Direct memory access (RM0090 10.5).
#pragma once

#include "boards/stm32f407/registers/access.hpp"
#include "boards/stm32f407/registers/memory_map.hpp"

namespace umov::boards::stm32f407 {

struct DmaStreamRegisters {
  Register CR, NDTR, PAR, M0AR, M1AR, FCR;
};
struct DmaRegisters {
  Register ISR[2], IFCR[2];  // low: streams 0 to 3, high: 4 to 7
  DmaStreamRegisters stream[8];
};
static_assert(sizeof(DmaRegisters) == 0xD0);

inline DmaRegisters& dma1() {
  return at<DmaRegisters>(memory_map::dma1);
}
inline DmaRegisters& dma2() {
  return at<DmaRegisters>(memory_map::dma2);
}

namespace dma_bits {
inline constexpr std::uint32_t EN = bit(0), TEIE = bit(2), HTIE = bit(3), TCIE = bit(4);
inline constexpr std::uint32_t MEMORY_TO_PERIPHERAL = 1u << 6, CIRC = bit(8), MINC = bit(10);
inline constexpr std::uint32_t PSIZE_WORD = 2u << 11, MSIZE_WORD = 2u << 13;
inline constexpr std::uint32_t PRIORITY_VERY_HIGH = 3u << 16;
constexpr std::uint32_t CHSEL(unsigned channel) {
  return channel << 25;
}
/// Flags of a stream within its status register.
inline constexpr std::uint32_t TEIF = bit(3), HTIF = bit(4), TCIF = bit(5), ALL = 0x3D;
/// Where the flags of a stream begin.
constexpr unsigned flag_shift(unsigned stream) {
  constexpr unsigned places[4] = {0, 6, 16, 22};
  return places[stream % 4];
}
}  // namespace dma_bits

}  // namespace umov::boards::stm32f407
