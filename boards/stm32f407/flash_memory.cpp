#include "boards/stm32f407/flash_memory.hpp"

#include "boards/stm32f407/registers/flash.hpp"

namespace umov::boards::stm32f407 {
namespace {

using namespace flash_bits;

/// Flash is open for writing while one lives.
class Unlocked {
 public:
  Unlocked() {
    FlashRegisters& f = flash_interface();
    if ((f.CR & LOCK) != 0) {
      f.KEYR = KEY1;
      f.KEYR = KEY2;
    }
    f.SR = ERRORS;
  }
  ~Unlocked() { flash_interface().CR = LOCK; }
  Unlocked(const Unlocked&) = delete;
  Unlocked& operator=(const Unlocked&) = delete;
};

bool wait() {
  while ((flash_interface().SR & BSY) != 0) {
  }
  return (flash_interface().SR & ERRORS) == 0;
}

/// Words read before may still be in the data cache.
void forget_cached() {
  FlashRegisters& f = flash_interface();
  const std::uint32_t settings = f.ACR;
  f.ACR = settings & ~DCEN;
  f.ACR = (settings & ~DCEN) | DCRST;
  f.ACR = settings;
}

}  // namespace

bool erase(const FlashArea& area) {
  const Unlocked open;
  FlashRegisters& f = flash_interface();
  if (!wait()) return false;
  f.CR = PSIZE_32 | SER | SNB(area.sector);
  f.CR = PSIZE_32 | SER | SNB(area.sector) | STRT;
  const bool done = wait();
  forget_cached();
  return done;
}

bool program(std::uintptr_t address, std::span<const std::uint32_t> words) {
  const Unlocked open;
  FlashRegisters& f = flash_interface();
  if (!wait()) return false;
  f.CR = PSIZE_32 | PG;
  auto* place = reinterpret_cast<volatile std::uint32_t*>(address);
  bool good = true;
  for (std::size_t i = 0; i < words.size() && good; ++i) {
    place[i] = words[i];
    good = wait();
  }
  forget_cached();
  for (std::size_t i = 0; i < words.size() && good; ++i) good = place[i] == words[i];
  return good;
}

}  // namespace umov::boards::stm32f407
