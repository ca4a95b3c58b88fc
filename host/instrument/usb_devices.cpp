#include "host/instrument/usb_devices.hpp"

#include <dirent.h>
#include <hidapi.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <system_error>

#include "host/instrument/embedded_udev_rule.hpp"
#include "host/instrument/libusb_handles.hpp"
#include "protocol/usb.hpp"

namespace umov::instrument {
namespace {

namespace fs = std::filesystem;
namespace usb = protocol::usb;

std::string node_of(libusb_device* device) {
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), "/dev/bus/usb/%03d/%03d", libusb_get_bus_number(device),
                libusb_get_device_address(device));
  return text.data();
}

std::string string_of(libusb_device_handle* handle, std::uint8_t index) {
  std::array<unsigned char, 128> text{};
  const int size = index == 0 ? 0
                              : libusb_get_string_descriptor_ascii(handle, index, text.data(),
                                                                   static_cast<int>(text.size()));
  return size > 0 ? std::string(text.begin(), text.begin() + size) : std::string();
}

/// False when it is somebody else's device with the shared id.
bool describe(libusb_device* device, std::uint16_t product_id, OpenUsbDevice& found) {
  UsbDeviceInfo& info = found.info;
  libusb_device_descriptor descriptor{};
  if (libusb_get_device_descriptor(device, &descriptor) != 0 ||
      descriptor.idVendor != usb::vendor_id || descriptor.idProduct != product_id) {
    return false;
  }
  info.node = node_of(device);
  libusb_device_handle* raw = nullptr;
  const int code = libusb_open(device, &raw);
  if (code == LIBUSB_ERROR_ACCESS) return true;  // perhaps ours: told, so that it can be opened
  if (code != 0) return false;
  found.handle.reset(raw);
  if (string_of(raw, descriptor.iManufacturer) != usb::manufacturer) return false;
  info.serial = string_of(raw, descriptor.iSerialNumber);
  info.product = string_of(raw, descriptor.iProduct);
  info.accessible = true;
  return true;
}

/// hidapi's wide strings hold ASCII here.
std::string narrow(const wchar_t* text) {
  std::string out;
  for (; text != nullptr && *text != L'\0'; ++text) {
    out.push_back(*text < 128 ? static_cast<char>(*text) : '?');
  }
  return out;
}

bool before(const UsbDeviceInfo& a, const UsbDeviceInfo& b) {
  return a.serial != b.serial ? a.serial < b.serial : a.node < b.node;
}

/// "usb:A, usb:B".
std::string names_of(const std::vector<UsbDeviceInfo>& devices, const std::string& kind) {
  std::string names;
  for (const auto& device : devices) {
    if (device.serial.empty()) continue;
    names += (names.empty() ? "" : ", ") + kind + ":" + device.serial;
  }
  return names;
}

}  // namespace

std::vector<OpenUsbDevice> find_usb_devices(libusb_context* context, std::uint16_t product_id) {
  libusb_device** list = nullptr;
  const auto count = libusb_get_device_list(context, &list);
  std::vector<OpenUsbDevice> found;
  for (ssize_t i = 0; i < count; ++i) {
    OpenUsbDevice device;
    if (describe(list[i], product_id, device)) found.push_back(std::move(device));
  }
  if (count >= 0) libusb_free_device_list(list, 1);
  std::sort(found.begin(), found.end(),
            [](const auto& a, const auto& b) { return before(a.info, b.info); });
  return found;
}

std::vector<UsbDeviceInfo> list_usb_devices() {
  const UsbContext context = open_usb_context();
  std::vector<UsbDeviceInfo> infos;
  for (const auto& device : find_usb_devices(context.get())) infos.push_back(device.info);
  return infos;
}

std::vector<UsbDeviceInfo> list_hid_devices() {
  std::vector<UsbDeviceInfo> found;
  hid_device_info* list = hid_enumerate(usb::vendor_id, usb::product_id);
  for (const hid_device_info* entry = list; entry != nullptr; entry = entry->next) {
    if (entry->interface_number != usb::interface::reports ||
        narrow(entry->manufacturer_string) != usb::manufacturer) {
      continue;
    }
    found.push_back({narrow(entry->serial_number), narrow(entry->product_string), entry->path,
                     ::access(entry->path, R_OK | W_OK) == 0});
  }
  hid_free_enumeration(list);
  std::sort(found.begin(), found.end(), before);
  return found;
}

std::string holder_of(const std::string& node) {
  std::error_code error;
  for (const auto& process : fs::directory_iterator("/proc", error)) {
    const std::string number = process.path().filename();
    if (number.find_first_not_of("0123456789") != std::string::npos) continue;
    if (number == std::to_string(::getpid())) continue;
    std::error_code denied;
    for (const auto& descriptor : fs::directory_iterator(process.path() / "fd", denied)) {
      if (fs::read_symlink(descriptor.path(), denied) != node) continue;
      std::ifstream file(process.path() / "comm");
      std::string name;
      std::getline(file, name);
      return name + " (process " + number + ")";
    }
  }
  return {};
}

UsbDeviceInfo choose_device(const std::vector<UsbDeviceInfo>& found, const std::string& kind,
                            const std::string& serial) {
  std::vector<UsbDeviceInfo> fitting;
  const UsbDeviceInfo* closed = nullptr;
  for (const auto& device : found) {
    const bool may_fit = serial.empty() || device.serial.empty() || device.serial == serial;
    if (!may_fit) continue;
    if (device.accessible) {
      fitting.push_back(device);
    } else {
      closed = &device;
    }
  }
  const std::string name = serial.empty() ? kind : kind + ":" + serial;
  if (fitting.size() == 1) return fitting.front();
  if (fitting.size() > 1) {
    throw Error({name}, "more than one controller is plugged in",
                "name one of them: " + names_of(fitting, kind));
  }
  if (closed != nullptr) {
    throw Error({name}, "you may not open the controller at " + closed->node, permission_remedy());
  }
  const std::string others = names_of(found, kind);
  throw Error({name},
              serial.empty() ? "no controller is plugged in" : "that controller is not plugged in",
              others.empty() ? "check cable and power; umov device list shows what is there"
                             : "plugged in are: " + others);
}

void throw_busy(const std::string& name, const std::string& node) {
  const std::string holder = holder_of(node);
  throw Error({name},
              holder.empty() ? "another program has opened the controller"
                             : "the controller is in use by " + holder,
              "end that program first");
}

std::string permission_remedy() {
  return "install the rule for udev: umov device udev-rule | sudo tee "
         "/etc/udev/rules.d/60-umov.rules && sudo udevadm control --reload && sudo udevadm trigger";
}

std::string udev_rule() {
  return std::string(embedded_udev_rule);
}

}  // namespace umov::instrument
