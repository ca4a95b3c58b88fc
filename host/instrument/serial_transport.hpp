// A controller on a serial line.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "host/instrument/transport.hpp"

namespace umov::instrument {

/// Opens the line, 8N1 without flow control, for this program alone. Throws umov::Error when it is
/// no serial line, may not be opened, is in use, or does not know the speed. The transport throws
/// LinkLost when the adapter is pulled.
std::unique_ptr<Transport> connect_serial_line(const std::string& path, std::uint32_t baud);

}  // namespace umov::instrument
