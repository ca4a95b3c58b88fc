// The fault log of the native board: RAM that outlives the board when the caller keeps it.
#pragma once

#include <deque>

#include "firmware/core/port.hpp"

namespace umov::boards::native {

/// The newest 64 faults.
class RamLog final : public firmware::PersistentLog {
 public:
  void append(const firmware::LoggedFault& entry) override;
  std::uint16_t count() const override;
  bool read(std::uint16_t index, firmware::LoggedFault& entry) const override;

 private:
  static constexpr std::size_t capacity = 64;
  std::deque<firmware::LoggedFault> entries_;
};

}  // namespace umov::boards::native
