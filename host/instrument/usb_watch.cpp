#include "host/instrument/usb_watch.hpp"

#include <sys/time.h>

#include <algorithm>
#include <chrono>
#include <string>
#include <vector>

#include "host/instrument/libusb_handles.hpp"
#include "protocol/usb.hpp"

namespace umov::instrument {
namespace {

using Clock = std::chrono::steady_clock;

/// A device that has just come can't be opened yet: its node gets its rights a moment later.
constexpr std::chrono::milliseconds settle{200};
constexpr std::chrono::milliseconds look_again{1000};

int LIBUSB_CALL on_event(libusb_context*, libusb_device*, libusb_hotplug_event, void* changed) {
  *static_cast<bool*>(changed) = true;
  return 0;  // goes on
}

/// Events about controllers set `changed`. Without hotplug support nothing ever does.
void subscribe(libusb_context* context, bool& changed) {
  if (libusb_has_capability(LIBUSB_CAP_HAS_HOTPLUG) == 0) return;
  (void)libusb_hotplug_register_callback(
      context, LIBUSB_HOTPLUG_EVENT_DEVICE_ARRIVED | LIBUSB_HOTPLUG_EVENT_DEVICE_LEFT,
      LIBUSB_HOTPLUG_NO_FLAGS, protocol::usb::vendor_id, protocol::usb::product_id,
      LIBUSB_HOTPLUG_MATCH_ANY, on_event, &changed, nullptr);
}

/// Whether `devices` holds it, rights and name as they were; of one that has gone the node tells.
bool holds(const std::vector<UsbDeviceInfo>& devices, const UsbDeviceInfo& device) {
  return std::any_of(devices.begin(), devices.end(), [&](const auto& other) {
    return other.node == device.node && other.serial == device.serial &&
           other.accessible == device.accessible;
  });
}
bool holds_node(const std::vector<UsbDeviceInfo>& devices, const std::string& node) {
  return std::any_of(devices.begin(), devices.end(),
                     [&](const auto& other) { return other.node == node; });
}

}  // namespace

void watch_usb_devices(
    const std::function<void(const UsbDeviceInfo& device, bool present)>& on_change,
    const std::function<bool()>& keep_going) {
  const UsbContext context = open_usb_context();
  bool changed = false;
  subscribe(context.get(), changed);
  std::vector<UsbDeviceInfo> known;
  auto look_at = Clock::now();
  while (keep_going()) {
    if (Clock::now() >= look_at) {
      const auto found = list_usb_devices();
      for (const auto& device : known) {
        if (!holds_node(found, device.node)) on_change(device, false);
      }
      for (const auto& device : found) {
        if (!holds(known, device)) on_change(device, true);
      }
      known = found;
      look_at = Clock::now() + look_again;
    }
    timeval limit{};
    limit.tv_usec = 100'000;
    libusb_handle_events_timeout_completed(context.get(), &limit, nullptr);
    if (changed) {
      changed = false;
      look_at = std::min(look_at, Clock::now() + settle);
    }
  }
}

}  // namespace umov::instrument
