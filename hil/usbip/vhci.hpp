// Plugging a device into this machine's kernel (module vhci-hcd), without a network in between.
#pragma once

#include <cstdint>

#include "host/net/socket.hpp"

namespace umov::usbip {

/// Gives the kernel one end of a socket pair as a full-speed device in a free port of its virtual
/// host controller and returns the other end. When that is closed, by the program's death too, the
/// device is unplugged. Throws umov::Error where vhci-hcd is not loaded, no port is free, or the
/// user may not.
net::Socket attach_to_kernel(std::uint32_t device_id);

}  // namespace umov::usbip
