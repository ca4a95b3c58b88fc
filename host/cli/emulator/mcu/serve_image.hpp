// The emulated board behind a TCP port, or at a virtual USB cable.
#pragma once

#include <functional>
#include <string>

#include "host/cli/emulator/emulated_instrument.hpp"

namespace umov::emulator {

/// Serves the board that runs `image` on TCP, one host at a time, until `keep_going` says no. The
/// board's clock follows the wall clock (or stays behind it where the emulation is slower): its
/// program gives a silent host the same seconds as on a desk. `options.real_time` has no effect.
void serve_image(const BenchOptions& bench, const std::string& image, const ServeOptions& options,
                 const std::function<bool()>& keep_going);

/// The same as a USB device on a virtual cable, like serve_usb().
void serve_image_usb(const BenchOptions& bench, const std::string& image, const UsbOptions& options,
                     const std::function<bool()>& keep_going);

}  // namespace umov::emulator
