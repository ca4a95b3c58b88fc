// Single pins: how they are set up, read and driven.
#pragma once

#include "boards/stm32f407/registers/gpio.hpp"

namespace umov::boards::stm32f407 {

enum class PinMode : std::uint32_t { input = 0, output = 1, alternate = 2, analog = 3 };
enum class Pull : std::uint32_t { none = 0, up = 1, down = 2 };

inline bool read(Pin pin) {
  return (gpio(pin.port).IDR & pin.mask()) != 0;
}
/// What BSRR takes to drive a pin high or low.
constexpr std::uint32_t set_reset_word(Pin pin, bool high) {
  return high ? pin.mask() : pin.mask() << 16;
}
/// One store: safe in any context.
inline void drive(Pin pin, bool high) {
  gpio(pin.port).BSRR = set_reset_word(pin, high);
}

/// At start only: changes registers that a port's pins share.
inline void configure(Pin pin, PinMode mode, Pull pull = Pull::none) {
  GpioRegisters& port = gpio(pin.port);
  const unsigned place = 2u * pin.number;
  change_bits(port.PUPDR, 3u << place, static_cast<std::uint32_t>(pull) << place);
  change_bits(port.MODER, 3u << place, static_cast<std::uint32_t>(mode) << place);
}
/// An output that is low from the moment on which it drives.
inline void configure_output(Pin pin) {
  drive(pin, false);
  configure(pin, PinMode::output);
}
/// Alternate function `function` (datasheet DS8626 table 9).
inline void configure_alternate(Pin pin, unsigned function, Pull pull = Pull::none) {
  const unsigned place = 4u * (pin.number % 8u);
  change_bits(gpio(pin.port).AFR[pin.number / 8u], 15u << place, function << place);
  configure(pin, PinMode::alternate, pull);
}

}  // namespace umov::boards::stm32f407
