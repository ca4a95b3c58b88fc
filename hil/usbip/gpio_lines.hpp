// What the pins of a GPIO adapter are wired to.
#pragma once

#include <optional>

namespace umov::usbip {

/// Wires between an adapter's pins and a board; numbers are the adapter's pins.
class GpioLines {
 public:
  virtual ~GpioLines() = default;
  /// The adapter drives a wire, or lets go of it (its pin is an input).
  virtual void drive(int pin, std::optional<bool> level) = 0;
  /// The level on the wire now.
  virtual bool level(int pin) const = 0;
};

}  // namespace umov::usbip
