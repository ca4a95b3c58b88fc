#include "hil/plant/driven_modulation.hpp"

namespace umov::plant {

bool DrivenModulation::quarter_ahead(std::uint64_t number, bool level) {
  if (number == 0) *this = {};
  if (level && !levels_.empty() && !levels_.back()) {
    if (rose_) period_ = levels_.size() - rose_at_;
    rose_at_ = levels_.size();
    rose_ = true;
  }
  levels_.push_back(level);
  if (period_ == 0) return level;
  const std::uint64_t back = (3 * period_ + 2) / 4;
  return levels_[levels_.size() - 1 - back];
}

}  // namespace umov::plant
