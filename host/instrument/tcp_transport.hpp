// A controller behind a TCP port: `tcp:HOST:PORT`.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

#include "host/instrument/transport.hpp"

namespace umov::instrument {

/// Connects (within 3 s unless told otherwise). Throws umov::Error "cannot reach HOST:PORT: …".
/// The transport's clock is wall time since the Unix epoch.
std::unique_ptr<Transport> connect_tcp(
    const std::string& host, std::uint16_t port,
    std::chrono::milliseconds timeout = std::chrono::milliseconds(3000));

}  // namespace umov::instrument
