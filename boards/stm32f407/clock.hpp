// Clocks: 8 MHz crystal -> PLL -> 168 MHz core, 42 MHz APB1 (timers 84), 84 MHz APB2 (timers 168).
#pragma once

#include <cstdint>

#include "boards/stm32f407/board_description.hpp"

namespace umov::boards::stm32f407 {

inline constexpr std::uint32_t apb1_hz = core_hz / 4;
inline constexpr std::uint32_t apb2_hz = core_hz / 2;
inline constexpr std::uint32_t apb1_timer_hz = 2 * apb1_hz;
inline constexpr std::uint32_t apb2_timer_hz = 2 * apb2_hz;

/// Once, first of all: full speed, and the clocks of every block in use.
void start_clocks();
/// Back to the internal oscillator and to what a reset leaves switched on.
void stop_clocks();

}  // namespace umov::boards::stm32f407
