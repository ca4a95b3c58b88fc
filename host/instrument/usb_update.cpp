#include "host/instrument/usb_update.hpp"

#include <algorithm>
#include <array>
#include <thread>
#include <utility>

#include "host/errors/error.hpp"
#include "host/instrument/libusb_handles.hpp"
#include "host/instrument/link_lost.hpp"
#include "host/instrument/rom_loader.hpp"
#include "protocol/dfu.hpp"
#include "protocol/usb.hpp"

namespace umov::instrument {
namespace {

namespace dfu = protocol::dfu;
namespace usb = protocol::usb;

/// Longer than the longest erasure, during which the chip answers nothing.
constexpr unsigned request_timeout_ms = 20'000;
constexpr std::chrono::milliseconds look_again{200};

constexpr std::uint8_t class_out = static_cast<std::uint8_t>(LIBUSB_REQUEST_TYPE_CLASS) |
                                   static_cast<std::uint8_t>(LIBUSB_RECIPIENT_INTERFACE);
constexpr std::uint8_t class_in = class_out | static_cast<std::uint8_t>(LIBUSB_ENDPOINT_IN);

UsbHandle take(std::vector<OpenUsbDevice>& found, const UsbDeviceInfo& device) {
  return std::move(std::find_if(found.begin(), found.end(), [&](const auto& one) {
                     return one.info.node == device.node;
                   })->handle);
}

std::vector<UsbDeviceInfo> infos_of(const std::vector<OpenUsbDevice>& found) {
  std::vector<UsbDeviceInfo> infos;
  for (const auto& one : found) infos.push_back(one.info);
  return infos;
}

class LibusbDfuPipe final : public DfuPipe {
 public:
  LibusbDfuPipe(UsbContext context, UsbHandle handle, std::string name)
      : context_(std::move(context)), handle_(std::move(handle)), name_(std::move(name)) {}
  ~LibusbDfuPipe() override { libusb_release_interface(handle_.get(), 0); }
  LibusbDfuPipe(const LibusbDfuPipe&) = delete;
  LibusbDfuPipe& operator=(const LibusbDfuPipe&) = delete;

  Answer read(std::uint8_t request, std::uint16_t value, std::size_t length) override {
    std::vector<std::uint8_t> bytes(length);
    const int code =
        libusb_control_transfer(handle_.get(), class_in, request, value, 0, bytes.data(),
                                static_cast<std::uint16_t>(length), request_timeout_ms);
    if (code == LIBUSB_ERROR_PIPE) return {};
    if (code < 0) lose(code);
    bytes.resize(static_cast<std::size_t>(code));
    return {true, std::move(bytes)};
  }
  bool write(std::uint8_t request, std::uint16_t value,
             std::span<const std::uint8_t> bytes) override {
    std::vector<std::uint8_t> copy(bytes.begin(), bytes.end());  // libusb takes no const
    const int code =
        libusb_control_transfer(handle_.get(), class_out, request, value, 0, copy.data(),
                                static_cast<std::uint16_t>(copy.size()), request_timeout_ms);
    if (code == LIBUSB_ERROR_PIPE) return false;
    if (code < 0) lose(code);
    return true;
  }
  void wait(std::chrono::milliseconds duration) override { std::this_thread::sleep_for(duration); }
  std::string text(std::uint8_t index) override {
    std::array<unsigned char, 128> ascii{};
    const int size = libusb_get_string_descriptor_ascii(handle_.get(), index, ascii.data(),
                                                        static_cast<int>(ascii.size()));
    return size > 0 ? std::string(ascii.begin(), ascii.begin() + size) : std::string();
  }
  std::string name() const override { return name_; }

 private:
  [[noreturn]] void lose(int code) const {
    throw LinkLost(name_, std::string("connection lost: ") + libusb_strerror(code));
  }

  UsbContext context_;
  UsbHandle handle_;
  std::string name_;
};

}  // namespace

std::vector<UsbDeviceInfo> list_update_devices() {
  const UsbContext context = open_usb_context();
  return infos_of(find_usb_devices(context.get(), usb::update_product_id));
}

std::string restart_in_boot_loader(const std::string& serial) {
  const UsbContext context = open_usb_context();
  auto found = find_usb_devices(context.get());
  const UsbDeviceInfo device = choose_device(infos_of(found), "usb", serial);
  const std::string name = "usb:" + device.serial;
  const UsbHandle handle = take(found, device);
  int code = libusb_claim_interface(handle.get(), usb::interface::dfu);
  if (code == LIBUSB_ERROR_BUSY) throw_busy(name, device.node);
  constexpr std::uint16_t detach_within_ms = 1000;
  if (code == 0) {
    code = libusb_control_transfer(handle.get(), class_out, dfu::detach, detach_within_ms,
                                   usb::interface::dfu, nullptr, 0, request_timeout_ms);
  }
  if (code == LIBUSB_ERROR_PIPE) {
    throw Error({name},
                "the controller does not leave its program: it moves or measures, or has no "
                "boot loader",
                "wait until it is idle (umov device info), or end the scan; a board without a boot "
                "loader is flashed with a programmer or --rom");
  }
  // It may be gone before the answer has arrived.
  if (code < 0 && code != LIBUSB_ERROR_NO_DEVICE && code != LIBUSB_ERROR_IO) {
    throw LinkLost(name,
                   std::string("it can't be sent to its boot loader: ") + libusb_strerror(code));
  }
  return device.serial;
}

std::unique_ptr<DfuPipe> open_boot_loader(const std::string& serial, bool older_too) {
  UsbContext context = open_usb_context();
  auto found = find_usb_devices(context.get(), usb::update_product_id);
  const UsbDeviceInfo device = choose_device(infos_of(found), "usb", serial);
  const std::string name = "boot loader of usb:" + device.serial;
  UsbHandle handle = take(found, device);
  found.clear();
  int code = libusb_claim_interface(handle.get(), 0);
  if (code == LIBUSB_ERROR_BUSY) throw_busy(name, device.node);
  if (code == 0) {
    code = libusb_set_interface_alt_setting(
        handle.get(), 0, older_too ? dfu::setting_older_too : dfu::setting_newer);
  }
  if (code != 0) throw LinkLost(name, std::string("cannot use it: ") + libusb_strerror(code));
  return std::make_unique<LibusbDfuPipe>(std::move(context), std::move(handle), name);
}

std::string boot_loader_trouble(const std::string& serial) {
  try {
    return dfu_trouble(*open_boot_loader(serial, false));
  } catch (const Error&) {
    return {};  // somebody updates it, or it has gone back to its program
  }
}

std::unique_ptr<DfuPipe> open_rom_loader(std::chrono::seconds limit) {
  constexpr std::uint16_t st_vendor = 0x0483, rom_loader = 0xDF11;  // AN2606
  const std::string name = "ROM loader 0483:df11";
  const auto deadline = std::chrono::steady_clock::now() + limit;
  for (;;) {
    UsbContext context = open_usb_context();
    libusb_device** list = nullptr;
    const auto count = libusb_get_device_list(context.get(), &list);
    std::vector<libusb_device*> found;
    for (ssize_t i = 0; i < count; ++i) {
      libusb_device_descriptor descriptor{};
      if (libusb_get_device_descriptor(list[i], &descriptor) == 0 &&
          descriptor.idVendor == st_vendor && descriptor.idProduct == rom_loader) {
        found.push_back(list[i]);
      }
    }
    libusb_device_handle* raw = nullptr;
    int code = LIBUSB_ERROR_NO_DEVICE;
    if (found.size() == 1) code = libusb_open(found[0], &raw);
    UsbHandle handle(raw);
    if (count >= 0) libusb_free_device_list(list, 1);
    if (found.size() > 1) {
      throw Error({name}, "more than one chip is in its ROM loader", "unplug the others");
    }
    if (handle) {
      // Setting 0 is the flash.
      code = libusb_claim_interface(handle.get(), 0);
      if (code == 0) code = libusb_set_interface_alt_setting(handle.get(), 0, 0);
    }
    if (code == 0) {
      return std::make_unique<LibusbDfuPipe>(std::move(context), std::move(handle), name);
    }
    if (std::chrono::steady_clock::now() >= deadline) {
      if (code == LIBUSB_ERROR_ACCESS) {
        throw Error({name}, "you may not open it", permission_remedy());
      }
      throw Error({name}, "it does not appear on USB",
                  "check the USB cable and the lines BOOT0 (high) and NRST (a pulse to low)");
    }
    std::this_thread::sleep_for(look_again);
  }
}

bool wait_for_device(const UsbListing& list, const std::string& serial,
                     std::chrono::seconds limit) {
  const auto deadline = std::chrono::steady_clock::now() + limit;
  for (;;) {
    const auto found = list();
    if (std::any_of(found.begin(), found.end(), [&](const auto& device) {
          return device.accessible && device.serial == serial;
        })) {
      return true;
    }
    if (std::chrono::steady_clock::now() >= deadline) {
      // One that may not be opened does not tell its serial number.
      const auto closed = std::find_if(found.begin(), found.end(), [&](const auto& device) {
        return !device.accessible && (device.serial.empty() || device.serial == serial);
      });
      if (closed == found.end()) return false;
      throw Error({"usb:" + serial}, "you may not open the controller at " + closed->node,
                  permission_remedy());
    }
    std::this_thread::sleep_for(look_again);
  }
}

UsbDeviceInfo wait_for_new_device(const UsbListing& list, const std::vector<UsbDeviceInfo>& others,
                                  std::chrono::seconds limit) {
  const auto deadline = std::chrono::steady_clock::now() + limit;
  for (;;) {
    auto found = list();
    std::erase_if(found, [&](const auto& device) {
      return std::any_of(others.begin(), others.end(), [&](const auto& other) {
        return device.node == other.node ||
               (!device.serial.empty() && device.serial == other.serial);
      });
    });
    const bool there = std::any_of(found.begin(), found.end(),
                                   [](const auto& device) { return device.accessible; });
    if (there || std::chrono::steady_clock::now() >= deadline) {
      return choose_device(found, "usb", {});
    }
    std::this_thread::sleep_for(look_again);
  }
}

}  // namespace umov::instrument
