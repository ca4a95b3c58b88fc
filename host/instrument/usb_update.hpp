// Controllers on USB that are to be updated: from the program to the boot loader and back.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "host/instrument/dfu_client.hpp"
#include "host/instrument/usb_devices.hpp"

namespace umov::instrument {

/// Controllers whose boot loader waits for an image.
std::vector<UsbDeviceInfo> list_update_devices();

/// Asks the running program of that controller (the only one when `serial` is empty) to restart in
/// its boot loader; returns its serial number. Throws umov::Error when it is not there, may not be
/// opened, or refuses: it moves or measures, or has no boot loader.
std::string restart_in_boot_loader(const std::string& serial);

/// The DFU interface of the boot loader of that controller (the only one when `serial` is empty).
/// `older_too`: it shall take images older than the one that runs. Throws umov::Error when there is
/// none, or it may not be opened.
std::unique_ptr<DfuPipe> open_boot_loader(const std::string& serial, bool older_too);

/// Why the boot loader of that controller has no program to start, in its own words; empty when it
/// was asked to wait, works on an update, or is gone.
std::string boot_loader_trouble(const std::string& serial);

/// What list_usb_devices() or list_update_devices() tells, now.
using UsbListing = std::function<std::vector<UsbDeviceInfo>()>;

/// Looks for the controller again and again until it is there and may be opened; false when it is
/// not within `limit`. Throws umov::Error then if there is one that may not be opened, which may be
/// it.
bool wait_for_device(const UsbListing& list, const std::string& serial, std::chrono::seconds limit);

/// The one controller that is none of `others`, looked for again and again. Throws umov::Error when
/// there is none within `limit`, more than one, or it may not be opened.
UsbDeviceInfo wait_for_new_device(const UsbListing& list, const std::vector<UsbDeviceInfo>& others,
                                  std::chrono::seconds limit);

}  // namespace umov::instrument
