// The modulation as the board's output makes it, sample by sample, and where it will be a quarter
// of a period later.
#pragma once

#include <cstdint>
#include <vector>

namespace umov::plant {

/// A quarter period ahead is three quarters of a period ago: what is needed is the level then.
class DrivenModulation {
 public:
  /// Notes the level at sample `number` (0 begins a new stream) and returns the level a quarter
  /// period later, as it was one period before that; the level itself until a whole period has been
  /// seen.
  bool quarter_ahead(std::uint64_t number, bool level);

 private:
  std::vector<bool> levels_;
  std::uint64_t period_ = 0;  // samples from one rising edge to the next, 0 = not known
  std::uint64_t rose_at_ = 0;
  bool rose_ = false;
};

}  // namespace umov::plant
