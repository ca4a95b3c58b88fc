// The emulated board behind a TCP port, or at a virtual USB cable.
#pragma once

#include <functional>
#include <string>

#include "host/cli/emulator/emulated_instrument.hpp"

namespace umov::emulator {

/// ELF files that the emulated board runs.
struct BoardFiles {
  std::string image;        ///< umov-stm32f407.elf
  std::string boot_loader;  ///< umov-stm32f407-boot.elf; empty: the chip goes straight to the image
};

/// Serves the board that runs the image on TCP, one host at a time, until `keep_going` says no. The
/// board's clock follows the wall clock (or stays behind it where the emulation is slower): its
/// program gives a silent host the same seconds as on a desk. `options.real_time` has no effect.
void serve_image(const BenchOptions& bench, const BoardFiles& files, const ServeOptions& options,
                 const std::function<bool()>& keep_going);

/// The same as a USB device on a virtual cable, like serve_usb(). When the board takes itself off
/// the bus (it restarts in its boot loader, or in its program) and shows itself again, it is
/// plugged into this machine's kernel again; over USB/IP it has to be attached again.
void serve_image_usb(const BenchOptions& bench, const BoardFiles& files, const UsbOptions& options,
                     const std::function<bool()>& keep_going);

}  // namespace umov::emulator
