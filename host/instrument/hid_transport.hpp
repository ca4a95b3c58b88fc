// A controller on USB, over its HID reports (hidapi): `hid`, `hid:SERIAL`. Slower than `usb`, but
// needs no driver anywhere.
#pragma once

#include <memory>
#include <string>

#include "host/instrument/transport.hpp"

namespace umov::instrument {

/// Opens the controller of that serial number, or the only one there is when it is empty. One
/// program at a time: others are refused while it runs. Throws umov::Error as connect_usb does.
std::unique_ptr<Transport> connect_hid(const std::string& serial);

}  // namespace umov::instrument
