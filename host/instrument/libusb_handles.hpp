// libusb's objects, each of which ends itself. Only for the USB files of this folder.
#pragma once

#include <libusb.h>

#include <memory>
#include <string>
#include <vector>

#include "host/errors/error.hpp"
#include "host/instrument/usb_devices.hpp"
#include "protocol/usb.hpp"

namespace umov::instrument {

struct CloseContext {
  void operator()(libusb_context* context) const { libusb_exit(context); }
};
using UsbContext = std::unique_ptr<libusb_context, CloseContext>;

struct CloseDevice {
  void operator()(libusb_device_handle* handle) const { libusb_close(handle); }
};
using UsbHandle = std::unique_ptr<libusb_device_handle, CloseDevice>;

/// A context of its own sees what is plugged in now, also where no udev daemon tells of changes.
inline UsbContext open_usb_context() {
  libusb_context* context = nullptr;
  if (const int code = libusb_init(&context); code != 0) {
    throw Error(std::string("USB can't be used: ") + libusb_strerror(code),
                "is /dev/bus/usb there? use --device tcp:HOST:PORT without it");
  }
  return UsbContext(context);
}

/// The controllers that a context sees, by serial number, opened where the user may: those that run
/// their program, or with `update_product_id` those in their boot loader.
struct OpenUsbDevice {
  UsbDeviceInfo info;
  UsbHandle handle;
};
std::vector<OpenUsbDevice> find_usb_devices(libusb_context* context,
                                            std::uint16_t product_id = protocol::usb::product_id);

}  // namespace umov::instrument
