// The lines BOOT0 and NRST of a controller, on GPIO lines of this machine (libgpiod).
#pragma once

#include <memory>
#include <string>

namespace umov::instrument {

/// Where the two lines are. `chip`: name, label, path or number of a GPIO chip, as gpiodetect lists
/// them; the lines by their numbers on it.
struct BootLineNames {
  std::string chip;
  unsigned boot0 = 0;
  unsigned nrst = 0;
};

/// Holds both lines as long as it lives; lets go of NRST and leaves BOOT0 low at its end.
class BootLines {
 public:
  /// Throws umov::Error when chip or lines are not there, or in use.
  explicit BootLines(const BootLineNames& names);
  ~BootLines();
  BootLines(const BootLines&) = delete;
  BootLines& operator=(const BootLines&) = delete;

  /// Resets the chip with BOOT0 high (into its ROM loader) or low (into its flash). Takes 50 ms.
  void reset(bool into_rom);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace umov::instrument
