#include "host/instrument/boot_lines.hpp"

#include <chrono>
#include <thread>

#include "host/errors/error.hpp"

namespace umov::instrument {
namespace {

/// NRST low for at least 20 us (datasheet DS8626, table 56); adapters are slower than that. BOOT0
/// is read at the fourth clock after the reset.
constexpr std::chrono::milliseconds settle{10}, pulse{20};

/// At the end, when nobody is left to be told.
template <class Act>
void try_to(Act&& act) {
  try {
    act();
  } catch (const Error&) {
  }
}

}  // namespace

BootLines::~BootLines() {
  if (in_rom_) try_to([&] { reset(false); });
  try_to([&] { pins_->set_boot0(false); });
  try_to([&] { pins_->set_nrst(true); });
}

void BootLines::reset(bool into_rom) {
  pins_->set_boot0(into_rom);
  std::this_thread::sleep_for(settle);
  pins_->set_nrst(false);
  // From here on the chip may be in its ROM, also when the line can't be let go of.
  in_rom_ = into_rom;
  std::this_thread::sleep_for(pulse);
  pins_->set_nrst(true);
  std::this_thread::sleep_for(pulse);
}

}  // namespace umov::instrument
