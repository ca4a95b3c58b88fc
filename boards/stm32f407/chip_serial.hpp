// The serial number of this chip.
#pragma once

#include "boards/stm32f407/registers/memory_map.hpp"
#include "firmware/core/usb/descriptors.hpp"

namespace umov::boards::stm32f407 {

/// The chip's 96-bit number as 24 hexadecimal digits.
inline std::array<char, 24> chip_serial() {
  const auto* id = reinterpret_cast<const volatile std::uint32_t*>(memory_map::unique_id);
  return firmware::usb::serial_of_chip({id[0], id[1], id[2]});
}

}  // namespace umov::boards::stm32f407
