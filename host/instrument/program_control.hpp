// Small questions to and orders for a running program, shared by the files of ProgramStream.
#pragma once

#include <chrono>
#include <cstdint>

#include "host/instrument/session.hpp"
#include "protocol/messages.hpp"

namespace umov::instrument {

/// program_control.action
enum class ProgramAction : std::uint8_t { pause = 0, resume = 1, abort = 2 };

/// Gives the order. That it was not answered, or came too late, is left to the caller's next look
/// at the status: all three do no harm when they act twice. Throws Refused for other reasons.
void control_program(Session& session, ProgramAction action);

/// Attempts at things whose success the status tells.
inline constexpr int status_attempts = 12;

/// Scanning, waiting or paused: not at rest.
bool is_running(const protocol::Status& status);
bool is_idle(const protocol::Status& status);

inline std::uint64_t to_us(std::chrono::milliseconds duration) {
  return static_cast<std::uint64_t>(std::chrono::microseconds(duration).count());
}

}  // namespace umov::instrument
