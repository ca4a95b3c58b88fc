// The one file that knows libgpiod, in its version 1.
#include "host/instrument/boot_lines.hpp"

#include <gpiod.h>

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <memory>
#include <string>

#include "host/errors/error.hpp"

namespace umov::instrument {
namespace {

constexpr const char* consumer = "umov";

struct CloseChip {
  void operator()(gpiod_chip* chip) const { gpiod_chip_close(chip); }
};
struct ReleaseLine {
  void operator()(gpiod_line* line) const { gpiod_line_release(line); }
};
using Line = std::unique_ptr<gpiod_line, ReleaseLine>;

Line request(const BootLineNames& names, gpiod_chip* chip, unsigned number, int level, int flags) {
  gpiod_line* raw = gpiod_chip_get_line(chip, number);
  const int code =
      raw == nullptr ? -1 : gpiod_line_request_output_flags(raw, consumer, flags, level);
  if (code != 0) {
    throw Error({names.chip}, "line " + std::to_string(number) + ": " + std::strerror(errno),
                "gpioinfo lists the lines of a chip and who uses them");
  }
  return Line(raw);
}

/// A GPIO chip that this user may not open; empty when there is none.
std::string closed_chip() {
  std::error_code none;
  for (const auto& entry : std::filesystem::directory_iterator("/dev", none)) {
    const auto name = entry.path().filename().string();
    if (name.starts_with("gpiochip") && ::access(entry.path().c_str(), R_OK | W_OK) != 0 &&
        errno == EACCES) {
      return entry.path();
    }
  }
  return {};
}

/// libgpiod looks chips up by name and label, for which it opens all: one that is closed ends the
/// search, and what it reports then is that there is none of that name.
[[noreturn]] void throw_no_chip(const std::string& name, int reason) {
  const std::string closed = closed_chip();
  if (!closed.empty()) {
    throw Error({name}, "you may not open the GPIO chip at " + closed,
                "run as root, or add a rule for udev: SUBSYSTEM==\"gpio\", KERNEL==\"gpiochip*\", "
                "MODE=\"0660\", GROUP=\"plugdev\"");
  }
  if (reason == ENOENT || reason == ENODEV) {
    throw Error({name}, "no such GPIO chip", "gpiodetect lists the chips there are");
  }
  throw Error({name}, std::string("the GPIO chip can't be opened: ") + std::strerror(reason),
              "gpiodetect lists the chips there are");
}

class GpiodPins final : public BootPins {
 public:
  explicit GpiodPins(const BootLineNames& names)
      : name_(names.chip), chip_(gpiod_chip_open_lookup(names.chip.c_str())) {
    if (!chip_) throw_no_chip(names.chip, errno);
    boot0_ = request(names, chip_.get(), names.boot0, 0, 0);
    nrst_ = request(names, chip_.get(), names.nrst, 1, GPIOD_LINE_REQUEST_FLAG_OPEN_DRAIN);
  }
  void set_boot0(bool high) override { set(boot0_, high); }
  void set_nrst(bool high) override { set(nrst_, high); }

 private:
  void set(const Line& line, bool high) const {
    if (gpiod_line_set_value(line.get(), high ? 1 : 0) != 0) {
      throw Error({name_}, std::string("a line can't be set: ") + std::strerror(errno),
                  "check the GPIO adapter's cable");
    }
  }

  std::string name_;
  std::unique_ptr<gpiod_chip, CloseChip> chip_;
  Line boot0_, nrst_;
};

}  // namespace

std::unique_ptr<BootPins> open_boot_pins(const BootLineNames& names) {
  return std::make_unique<GpiodPins>(names);
}

}  // namespace umov::instrument
