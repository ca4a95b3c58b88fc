// Why the chip started.
#pragma once

#include <cstdint>

#include "firmware/core/port.hpp"

namespace umov::boards::stm32f407 {

struct ResetReport {
  firmware::ResetCause cause = firmware::ResetCause::power_on;
  std::int32_t program_counter = -1;  ///< where a processor fault happened, -1: not known
};

/// Once, at start: reads the reset flags, the chip's or what the boot loader took from it, and the
/// note of a processor fault, and clears them for the next time. A supply that came up from nothing
/// sets the brown-out flag too and is a power-on; a reset that the program asked for without a note
/// was wanted and counts as one.
ResetReport take_reset_cause();

/// A processor fault happened at `program_counter`: notes it where a reset leaves it, and resets.
/// Any context, however broken.
[[noreturn]] void reset_after_fault(std::uint32_t program_counter);

}  // namespace umov::boards::stm32f407
