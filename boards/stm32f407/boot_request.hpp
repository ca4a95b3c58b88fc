// What program and boot loader tell each other over a reset, and the boot loader the program it
// starts: four words at the end of the memory, which neither uses and a reset leaves alone; and the
// mark by which a program knows that there is a boot loader.
#pragma once

#include <cstdint>

#include "boards/stm32f407/registers/core.hpp"
#include "boards/stm32f407/registers/memory_map.hpp"

namespace umov::boards::stm32f407 {

enum class BootRequest : std::uint32_t {
  none = 0,
  update = 0x2155'4644,   ///< stay in the boot loader, a host wants to update
  started = 0x2154'5241,  ///< the reset came from within the boot loader: an ordinary start
};

struct BootWords {
  Register request, inverted;
  Register reset_flags, inverted_flags;
};
inline BootWords& boot_words() {
  return at<BootWords>(memory_map::sram + 128 * 1024 - 16);
}

/// What the boot loader finds when the next reset comes, whatever its cause.
inline void leave_boot_request(BootRequest request) {
  boot_words().request = static_cast<std::uint32_t>(request);
  boot_words().inverted = ~static_cast<std::uint32_t>(request);
}

[[noreturn]] inline void reset_with(BootRequest request) {
  leave_boot_request(request);
  asm volatile("dsb" : : : "memory");
  constexpr std::uint32_t key = 0x05FA'0000, system_reset = 1u << 2;
  scb().AIRCR = key | system_reset;
  for (;;) {
  }
}

/// Reads the request and takes it away; none after a power-on, when memory holds anything.
inline BootRequest take_boot_request() {
  const std::uint32_t request = boot_words().request;
  const bool valid = boot_words().inverted == ~request;
  boot_words().request = 0;
  boot_words().inverted = 0;
  if (!valid) return BootRequest::none;
  if (request == static_cast<std::uint32_t>(BootRequest::update)) return BootRequest::update;
  if (request == static_cast<std::uint32_t>(BootRequest::started)) return BootRequest::started;
  return BootRequest::none;
}

/// The boot loader clears the chip's reset flags: they would pile up over the starts of a program
/// that does not come to do so. What they said, it tells the program.
inline void hand_over_reset_flags(std::uint32_t flags) {
  boot_words().reset_flags = flags;
  boot_words().inverted_flags = ~flags;
}

/// False when no boot loader has handed any over. Takes them away.
inline bool take_reset_flags(std::uint32_t& flags) {
  flags = boot_words().reset_flags;
  const bool valid = boot_words().inverted_flags == ~flags;
  boot_words().inverted_flags = flags;
  return valid;
}

/// Stands behind the boot loader's vectors, at 0x08000040.
struct BootMark {
  std::uint32_t word[2];
};
inline constexpr std::uintptr_t boot_mark_address = memory_map::flash + 0x40;
inline constexpr BootMark boot_mark = {{0x564F'4D55, 0x544F'4F42}};  // "UMOVBOOT"

inline bool has_boot_loader() {
  const auto* word = reinterpret_cast<const volatile std::uint32_t*>(boot_mark_address);
  return word[0] == boot_mark.word[0] && word[1] == boot_mark.word[1];
}

}  // namespace umov::boards::stm32f407
