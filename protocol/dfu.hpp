// Names and numbers of USB Device Firmware Upgrade 1.1 (sections 3, 4 and 6.1), and what the boot
// loader's two settings mean. Freestanding C++20, no heap.
#pragma once

#include <cstdint>

namespace umov::protocol::dfu {

/// bRequest.
inline constexpr std::uint8_t detach = 0, download = 1, upload = 2, get_status = 3,
                              clear_status = 4, get_state = 5, abort = 6;

enum class State : std::uint8_t {
  app_idle = 0,
  app_detach = 1,
  idle = 2,
  download_sync = 3,
  download_busy = 4,
  download_idle = 5,
  manifest_sync = 6,
  manifest = 7,
  manifest_wait_reset = 8,
  upload_idle = 9,
  error = 10,
};

enum class Status : std::uint8_t {
  ok = 0,
  wrong_target = 1,
  bad_file = 2,
  write_failed = 3,
  erase_failed = 4,
  program_failed = 6,
  verify_failed = 7,
  not_done = 9,
  no_firmware = 10,
  vendor = 11,
  stalled_packet = 15,
};

/// bInterfaceClass, -SubClass and -Protocol in DFU mode.
inline constexpr std::uint8_t interface_class = 0xfe, interface_subclass = 1, mode_protocol = 2;

/// Bytes of a transfer, wTransferSize.
inline constexpr std::uint16_t transfer_bytes = 1024;

/// bAlternateSetting of the boot loader's interface: refuses images older than the one that runs,
/// or takes them.
inline constexpr std::uint8_t setting_newer = 0, setting_older_too = 1;

}  // namespace umov::protocol::dfu
