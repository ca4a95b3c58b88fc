// Controllers that are plugged in and unplugged while the program looks.
#pragma once

#include <functional>

#include "host/instrument/usb_devices.hpp"

namespace umov::instrument {

/// Calls `on_change` for every controller on USB that is there already, and for each that comes
/// (true) or goes (false), until `keep_going` says no (asked several times a second). Told of
/// changes by the system's hotplug events, and by looking each second where there are none.
/// Throws umov::Error when USB can't be used at all.
void watch_usb_devices(
    const std::function<void(const UsbDeviceInfo& device, bool present)>& on_change,
    const std::function<bool()>& keep_going);

}  // namespace umov::instrument
