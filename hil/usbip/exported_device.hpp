// What USB/IP tells of a device before it is attached.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "hil/usbip/usb_function.hpp"

namespace umov::usbip {

/// A device that can be plugged into a virtual cable; the function must outlive it.
struct ExportedDevice {
  std::string bus_id;  ///< such as "1-1"
  UsbFunction* function = nullptr;
  std::vector<std::uint8_t> device_descriptor;  ///< 18 bytes
  std::vector<std::uint8_t> configuration;      ///< of the first configuration, whole
  std::uint32_t number = 1;                     ///< from 1; the device id is 1 << 16 | number
  std::uint32_t device_id() const { return (1u << 16) | number; }
};

/// Asks the function for its descriptors, as a host does. The function is reset. Throws
/// umov::Error when it doesn't answer.
ExportedDevice export_device(std::string bus_id, std::uint32_t number, UsbFunction& function);

/// Appends the 312 bytes that describe a device in lists and import replies.
void write_description(std::vector<std::uint8_t>& out, const ExportedDevice& device);
/// Appends 4 bytes for each interface, as lists have them.
void write_interfaces(std::vector<std::uint8_t>& out, const ExportedDevice& device);

}  // namespace umov::usbip
