// Why the chip started, and the watchdog that may be the reason next time.
#pragma once

#include "firmware/core/port.hpp"

namespace umov::boards::stm32f407 {

/// Once, at start: reads the reset flags and clears them for the next time. A supply that came up
/// from nothing sets the brown-out flag too and is a power-on.
firmware::ResetCause take_reset_cause();

/// Resets the chip unless fed within about 250 ms (170 to 470 ms: the clock of the watchdog is
/// coarse). Cannot be stopped again.
void start_watchdog();
void feed_watchdog();

}  // namespace umov::boards::stm32f407
