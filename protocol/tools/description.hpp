// PROTOCOL.md as text: framing, session and stream rules, and a table for every message.
#pragma once

#include <string>

namespace umov::protocol {

/// The whole of PROTOCOL.md, derived from the declarations in messages.hpp.
std::string describe_protocol();

/// The part of it that declarations can't say: how sessions, rows and records behave.
std::string describe_session_and_streams();

}  // namespace umov::protocol
