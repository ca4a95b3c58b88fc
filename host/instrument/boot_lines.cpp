// The one file that knows libgpiod, in its version 1.
#include "host/instrument/boot_lines.hpp"

#include <gpiod.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <thread>

#include "host/errors/error.hpp"

namespace umov::instrument {
namespace {

constexpr const char* consumer = "umov";
/// NRST low for at least 20 us (datasheet DS8626, table 56); adapters are slower than that. BOOT0
/// is read at the fourth clock after the reset.
constexpr std::chrono::milliseconds settle{10}, pulse{20};

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

}  // namespace

struct BootLines::Impl {
  explicit Impl(const BootLineNames& names) : name(names.chip) {
    chip.reset(gpiod_chip_open_lookup(names.chip.c_str()));
    if (!chip) {
      throw Error({names.chip}, std::string("no such GPIO chip: ") + std::strerror(errno),
                  "gpiodetect lists the chips there are");
    }
    boot0 = request(names, chip.get(), names.boot0, 0, 0);
    nrst = request(names, chip.get(), names.nrst, 1, GPIOD_LINE_REQUEST_FLAG_OPEN_DRAIN);
  }
  void set(const Line& line, int level) const {
    if (gpiod_line_set_value(line.get(), level) != 0) {
      throw Error({name}, std::string("a line can't be set: ") + std::strerror(errno),
                  "check the GPIO adapter's cable");
    }
  }

  std::string name;
  std::unique_ptr<gpiod_chip, CloseChip> chip;
  Line boot0, nrst;
};

BootLines::BootLines(const BootLineNames& names) : impl_(std::make_unique<Impl>(names)) {}

BootLines::~BootLines() {
  (void)gpiod_line_set_value(impl_->boot0.get(), 0);
  (void)gpiod_line_set_value(impl_->nrst.get(), 1);
}

void BootLines::reset(bool into_rom) {
  impl_->set(impl_->boot0, into_rom ? 1 : 0);
  std::this_thread::sleep_for(settle);
  impl_->set(impl_->nrst, 0);
  std::this_thread::sleep_for(pulse);
  impl_->set(impl_->nrst, 1);
  std::this_thread::sleep_for(pulse);
}

}  // namespace umov::instrument
