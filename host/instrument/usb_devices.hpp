// Controllers on this machine's USB.
#pragma once

#include <string>
#include <vector>

namespace umov::instrument {

/// A controller as its descriptors tell, found on the bus.
struct UsbDeviceInfo {
  std::string serial;   ///< empty where the user may not open it to ask
  std::string product;  ///< the same
  std::string node;     ///< such as /dev/bus/usb/001/004 or /dev/hidraw0
  bool accessible = false;
};

/// Every controller that libusb sees, by serial number. Throws umov::Error when USB can't be used
/// at all.
std::vector<UsbDeviceInfo> list_usb_devices();
/// The same as hidraw devices: one for the protocol's reports of each controller.
std::vector<UsbDeviceInfo> list_hid_devices();

/// The process that has a device node open, such as "umov (process 4711)"; empty when it can't be
/// told.
std::string holder_of(const std::string& node);

/// The one of that serial number, or the only one when `serial` is empty. `kind` is "usb" or "hid".
/// Throws umov::Error when there is none, more than one, or the user may not open it.
UsbDeviceInfo choose_device(const std::vector<UsbDeviceInfo>& found, const std::string& kind,
                            const std::string& serial);

/// Throws umov::Error that names the process which holds the node, if it can be told.
[[noreturn]] void throw_busy(const std::string& name, const std::string& node);

/// How to let users open controllers, for error messages.
std::string permission_remedy();

/// The rule for udev that does so.
std::string udev_rule();

}  // namespace umov::instrument
