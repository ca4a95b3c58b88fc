// The lines BOOT0 and NRST of a controller, on GPIO lines of this machine (libgpiod).
#pragma once

#include <memory>
#include <string>
#include <utility>

namespace umov::instrument {

/// Where the two lines are. `chip`: name, label, path or number of a GPIO chip, as gpiodetect lists
/// them; the lines by their numbers on it.
struct BootLineNames {
  std::string chip;
  unsigned boot0 = 0;
  unsigned nrst = 0;
};

/// The two lines as a chip sees them.
class BootPins {
 public:
  virtual ~BootPins() = default;
  /// Throws umov::Error when a line can't be set.
  virtual void set_boot0(bool high) = 0;
  /// `high` lets go of the line, which the board pulls up.
  virtual void set_nrst(bool high) = 0;
};

/// Takes those lines for this program: BOOT0 low, NRST let go of. Throws umov::Error when chip or
/// lines are not there, or in use.
std::unique_ptr<BootPins> open_boot_pins(const BootLineNames& names);

/// Holds both lines as long as it lives; lets go of NRST and leaves BOOT0 low at its end. A chip
/// that is in its ROM loader then is reset into its flash, as well as the lines can do that.
class BootLines {
 public:
  explicit BootLines(std::unique_ptr<BootPins> pins) : pins_(std::move(pins)) {}
  ~BootLines();
  BootLines(const BootLines&) = delete;
  BootLines& operator=(const BootLines&) = delete;

  /// Resets the chip with BOOT0 high (into its ROM loader) or low (into its flash). Takes 50 ms.
  /// Throws umov::Error when a line can't be set.
  void reset(bool into_rom);

 private:
  std::unique_ptr<BootPins> pins_;
  bool in_rom_ = false;
};

}  // namespace umov::instrument
