// Flash memory and its interface (RM0090 3): sectors, keys, programming that can only clear bits.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "hil/mcu/peripheral.hpp"

namespace umov::mcu {

/// Contents outlive a reset. While the bank is written the core stands still: `stall` is told for
/// how long (datasheet DS8626 table 47, typical: 16 us a word, .25/.55/1 s a sector of 16/64/128
/// KB).
class Flash : public Peripheral {
 public:
  static constexpr std::uint32_t base = 0x0800'0000;
  static constexpr std::size_t size = 1024 * 1024;
  static constexpr int sector_count = 12;

  Flash(std::vector<std::uint8_t>& contents, std::function<void(Time)> stall);

  std::uint32_t read(std::uint32_t offset) override;
  void write(std::uint32_t offset, std::uint32_t value) override;
  /// The program stores to the flash itself: programs when that has been opened, else sets an error
  /// flag and leaves the contents.
  void store(std::uint32_t address, unsigned bytes, std::uint32_t value);
  /// Sectors (bit n: sector n) that are protected by the option bytes: whoever erases or programs
  /// them gets an error flag, and they stay as they are.
  void protect(std::uint32_t sectors) { protected_ = sectors; }

  struct Sector {
    std::uint32_t begin, size;
  };
  static Sector sector(int number);

 private:
  void erase();
  bool refused(int sector);

  std::vector<std::uint8_t>* contents_;
  std::function<void(Time)> stall_;
  std::uint32_t acr_ = 0, sr_ = 0, cr_ = 0x8000'0000, protected_ = 0;
  int key_ = 0;  // keys given so far; -1 after a wrong one, until the next reset
};

}  // namespace umov::mcu
