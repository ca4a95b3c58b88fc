// A controller on USB, over its two bulk pipes (libusb): `usb`, `usb:SERIAL`.
#pragma once

#include <memory>
#include <string>

#include "host/instrument/transport.hpp"

namespace umov::instrument {

/// Opens the controller of that serial number, or the only one there is when it is empty. Several
/// reads are always in flight, so that the bus is never idle while the program works. A controller
/// that is unplugged ends in LinkLost within milliseconds. Throws umov::Error when there is none,
/// more than one, when another program has it, or when the user may not open it (with the way to
/// install the udev rule).
std::unique_ptr<Transport> connect_usb(const std::string& serial);

}  // namespace umov::instrument
