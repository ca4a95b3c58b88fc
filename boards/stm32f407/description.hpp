// Types of the generated description of the board (tools/describe.py): pins and what hangs on them.
#pragma once

#include <cstdint>

namespace umov::boards::stm32f407 {

enum class Port : std::uint8_t { A, B, C, D, E };

struct Pin {
  Port port = Port::A;
  std::uint8_t number = 0;  ///< 0 to 15

  constexpr std::uint32_t mask() const { return 1u << number; }
  constexpr bool operator==(const Pin&) const = default;
};

struct AnalogInput {
  Pin pin;
  std::uint8_t channel = 0;  ///< of ADC1 and ADC2
};

/// `channel` 1 to 4 of TIM1 captures the pin.
struct CaptureInput {
  Pin pin;
  std::uint8_t channel = 0;
};

/// What an axis is wired to. `timer` 2 or 5 and `channel` 1 to 4 drive the step pin.
struct AxisPins {
  Pin step, direction, home, lower_limit, upper_limit, stall;
  std::uint8_t timer = 0;
  std::uint8_t channel = 0;
};

}  // namespace umov::boards::stm32f407
