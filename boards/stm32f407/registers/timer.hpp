// Timers: advanced-control TIM1 and TIM8 (RM0090 17.4), general-purpose 32-bit TIM2 and TIM5
// (18.4).
#pragma once

#include "boards/stm32f407/registers/access.hpp"
#include "boards/stm32f407/registers/memory_map.hpp"

namespace umov::boards::stm32f407 {

struct TimerRegisters {
  Register CR1, CR2, SMCR, DIER, SR, EGR, CCMR[2], CCER, CNT, PSC, ARR, RCR, CCR[4], BDTR, DCR,
      DMAR, OR;
};
static_assert(sizeof(TimerRegisters) == 0x54);

inline TimerRegisters& tim1() {
  return at<TimerRegisters>(memory_map::tim1);
}
inline TimerRegisters& tim2() {
  return at<TimerRegisters>(memory_map::tim2);
}
inline TimerRegisters& tim5() {
  return at<TimerRegisters>(memory_map::tim5);
}
inline TimerRegisters& tim8() {
  return at<TimerRegisters>(memory_map::tim8);
}

namespace timer_bits {
inline constexpr std::uint32_t CEN = bit(0), URS = bit(2), ARPE = bit(7);  // CR1
inline constexpr std::uint32_t MMS_UPDATE = 2u << 4;                       // CR2: TRGO at updates
inline constexpr std::uint32_t UG = bit(0);                                // EGR
inline constexpr std::uint32_t UIF = bit(0);                               // SR
inline constexpr std::uint32_t CC1DE = bit(9);                             // DIER
/// Compare channel 1 to 4: flag, interrupt enable and software event share their place.
constexpr std::uint32_t CC(unsigned channel) {
  return bit(channel);
}
/// SR: a second capture before the first one was read.
constexpr std::uint32_t CCOF(unsigned channel) {
  return bit(8 + channel);
}
/// CCxS of an odd channel's half of CCMR: captures its own input, each edge, unfiltered.
inline constexpr std::uint32_t IC_OWN_INPUT = 1;
/// Enable of a channel's output, or capture, in CCER.
constexpr std::uint32_t CCE(unsigned channel) {
  return bit(4 * (channel - 1));
}
/// Output compare modes of OCxM.
inline constexpr std::uint32_t OC_FROZEN = 0, OC_HIGH_ON_MATCH = 1, OC_FORCE_LOW = 4,
                               OC_FORCE_HIGH = 5;
}  // namespace timer_bits

}  // namespace umov::boards::stm32f407
