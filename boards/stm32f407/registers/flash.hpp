// Flash memory interface (RM0090 3.9).
#pragma once

#include "boards/stm32f407/registers/access.hpp"
#include "boards/stm32f407/registers/memory_map.hpp"

namespace umov::boards::stm32f407 {

struct FlashRegisters {
  Register ACR, KEYR, OPTKEYR, SR, CR, OPTCR;
};

inline FlashRegisters& flash_interface() {
  return at<FlashRegisters>(memory_map::flash_interface);
}

namespace flash_bits {
inline constexpr std::uint32_t LATENCY_5 = 5, PRFTEN = bit(8), ICEN = bit(9), DCEN = bit(10),
                               DCRST = bit(12);                         // ACR
inline constexpr std::uint32_t KEY1 = 0x4567'0123, KEY2 = 0xCDEF'89AB;  // KEYR
inline constexpr std::uint32_t BSY = bit(16), ERRORS = 0xF2;            // SR
inline constexpr std::uint32_t PG = bit(0), SER = bit(1), PSIZE_32 = 2u << 8, STRT = bit(16),
                               LOCK = bit(31);  // CR
constexpr std::uint32_t SNB(unsigned sector) {
  return sector << 3;
}
}  // namespace flash_bits

}  // namespace umov::boards::stm32f407
