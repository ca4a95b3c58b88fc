// The fault log in flash: entries appended to one sector, each with its CRC; also counts the
// starts, so that every start has a number of its own.
#pragma once

#include <array>
#include <cstdint>

#include "boards/stm32f407/flash_memory.hpp"
#include "firmware/core/port.hpp"

namespace umov::boards::stm32f407 {

/// The newest 64 faults. A fault is written to flash by service(), when the axes stand: writing
/// holds the core up. A sector that is seven eighths full is erased at a start, before anything
/// moves, and the newest entries are written again; more than 340 faults between two starts are
/// kept in RAM only. An entry torn by a power cut is passed over; one while the sector is erased
/// takes the entries with it, not the count of starts.
/// Contexts: main loop.
class FlashLog final : public firmware::PersistentLog {
 public:
  /// Reads the sector and notes this start; returns its number, 1 for the first.
  std::uint32_t begin();

  void append(const firmware::LoggedFault& entry) override;
  std::uint16_t count() const override { return count_; }
  bool read(std::uint16_t index, firmware::LoggedFault& entry) const override;
  /// Writes what has not been written.
  void service();

  static constexpr std::uint16_t capacity = 64;

 private:
  void keep(const firmware::LoggedFault& entry);
  /// Empties the sector and notes this start; false when it was left as it was.
  bool make_room(std::uint32_t number);
  bool write(std::uint32_t kind, const firmware::LoggedFault& entry);

  std::array<firmware::LoggedFault, capacity> newest_{};  // ring
  std::uint16_t first_ = 0;
  std::uint16_t count_ = 0;
  std::uint16_t unwritten_ = 0;
  std::uint32_t used_ = 0;  // bytes of the sector
};

}  // namespace umov::boards::stm32f407
