// Waiting for a descriptor.
#pragma once

#include <chrono>

#include "host/net/socket.hpp"

namespace umov::net {

/// Waits until `socket` is ready for `events` (of poll.h), at most `timeout`, of which less than
/// nothing is nothing. One that hung up is ready. False on timeout, with errno as it was, and on a
/// signal, with errno EINTR.
bool wait_for(const Socket& socket, short events, std::chrono::microseconds timeout);

}  // namespace umov::net
