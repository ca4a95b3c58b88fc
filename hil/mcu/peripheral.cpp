#include "hil/mcu/peripheral.hpp"

#include <array>
#include <cstdio>

#include "host/errors/error.hpp"

namespace umov::mcu {
std::string hexadecimal(std::uint32_t value) {
  std::array<char, 16> text{};
  std::snprintf(text.data(), text.size(), "0x%08X", static_cast<unsigned>(value));
  return text.data();
}

void refuse_register(const char* block, std::uint32_t offset) {
  throw Error(std::string(block) + " has no register at offset " + hexadecimal(offset) +
                  " in the emulated chip",
              "use the registers that hil/mcu models, or model this one");
}

void refuse_setting(const char* block, const char* reg, std::uint32_t value) {
  throw Error(std::string(block) + " is asked by " + reg + " = " + hexadecimal(value) +
                  " for what the emulated chip can't do",
              "use a mode that hil/mcu models, or model this one");
}

}  // namespace umov::mcu
