#include "boards/native/ram_log.hpp"

namespace umov::boards::native {

void RamLog::append(const firmware::LoggedFault& entry) {
  entries_.push_front(entry);
  if (entries_.size() > capacity) entries_.pop_back();
}

std::uint16_t RamLog::count() const {
  return static_cast<std::uint16_t>(entries_.size());
}

bool RamLog::read(std::uint16_t index, firmware::LoggedFault& entry) const {
  if (index >= entries_.size()) return false;
  entry = entries_[index];
  return true;
}

}  // namespace umov::boards::native
