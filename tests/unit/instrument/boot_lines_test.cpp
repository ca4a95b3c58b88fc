// The lines that enter a chip's ROM loader, and what becomes of the chip when that goes wrong.
#include "host/instrument/boot_lines.hpp"

#include <gtest/gtest.h>

#include <stdexcept>
#include <vector>

#include "host/errors/error.hpp"

namespace umov::instrument {
namespace {

/// A chip at the lines: it reads BOOT0 when NRST rises.
struct Chip {
  bool boot0 = false, nrst = true;
  std::vector<bool> starts;  ///< of each reset, whether into the ROM
  bool broken = false;       ///< no line can be set any more
};

class Pins final : public BootPins {
 public:
  explicit Pins(Chip& chip) : chip_(&chip) {}
  void set_boot0(bool high) override {
    check();
    chip_->boot0 = high;
  }
  void set_nrst(bool high) override {
    check();
    if (high && !chip_->nrst) chip_->starts.push_back(chip_->boot0);
    chip_->nrst = high;
  }

 private:
  void check() const {
    if (chip_->broken) throw Error("unplugged", "plug it in");
  }
  Chip* chip_;
};

TEST(BootLines, AResetIntoTheRomAndBackIsTwoPulses) {
  Chip chip;
  {
    BootLines lines(std::make_unique<Pins>(chip));
    lines.reset(true);
    EXPECT_EQ(chip.starts, std::vector<bool>{true});
    lines.reset(false);
  }
  EXPECT_EQ(chip.starts, (std::vector<bool>{true, false})) << "and none at the end";
  EXPECT_FALSE(chip.boot0);
  EXPECT_TRUE(chip.nrst);
}

TEST(BootLines, AChipLeftInItsRomByAnErrorIsResetIntoItsFlash) {
  Chip chip;
  try {
    BootLines lines(std::make_unique<Pins>(chip));
    lines.reset(true);
    throw std::runtime_error("the loader does not answer");
  } catch (const std::runtime_error&) {
  }
  EXPECT_EQ(chip.starts, (std::vector<bool>{true, false}));
  EXPECT_FALSE(chip.boot0);
  EXPECT_TRUE(chip.nrst);
}

TEST(BootLines, AnAdapterThatIsPulledIsToldOnceAndNotAtTheEnd) {
  Chip chip;
  {
    BootLines lines(std::make_unique<Pins>(chip));
    lines.reset(true);
    chip.broken = true;
    EXPECT_THROW(lines.reset(false), Error);
  }
  EXPECT_EQ(chip.starts, std::vector<bool>{true});
}

}  // namespace
}  // namespace umov::instrument
