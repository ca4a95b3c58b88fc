// What the user should know of the image that runs: the detail of the faults rolled_back,
// no_fallback, and internal where it is no address.
// Freestanding C++20, no heap.
#pragma once

#include <cstdint>

#include "protocol/messages.hpp"

namespace umov::protocol {

/// Why an image was given up and the one before it put back.
enum class RollBackReason : std::uint8_t {
  damaged,   ///< it failed its check at a start
  watchdog,  ///< on trial; the last failed start was ended by the watchdog,
  crash,     ///< by a processor fault,
  button,    ///< or by the reset line
};

/// Detail of rolled_back: reason << 24 | version of the image given up, of which the upper byte of
/// the major part is left out.
constexpr std::int32_t roll_back_detail(RollBackReason reason, std::uint32_t version) {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(reason) << 24 |
                                   (version & 0xFF'FFFFu));
}
constexpr RollBackReason roll_back_reason(std::int32_t detail) {
  return static_cast<RollBackReason>(detail >> 24 & 0xFF);
}
/// 0: not known.
constexpr std::uint32_t roll_back_version(std::int32_t detail) {
  return static_cast<std::uint32_t>(detail) & 0xFF'FFFFu;
}

/// Detail of no_fallback: nothing can be put back, or only an image older than the one replaced.
inline constexpr std::int32_t none_to_fall_back_to = 0, only_an_older_one = 1;

/// Detail of internal: the image on trial has proved itself, and its flash does not take the note
/// of that. Odd, as no address of an instruction is.
inline constexpr std::int32_t trial_not_confirmed = 1;

}  // namespace umov::protocol
