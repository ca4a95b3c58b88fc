// Chooses the amplifier range from the peak codes of the lead-in.
#pragma once

#include <cstdint>

#include "protocol/messages.hpp"

namespace umov::firmware {

/// Remembers the range from row to row. Ranges are a factor of ten apart: a signal goes up only
/// when its peak would then stay below 70 % of full scale, and comes down when a code is clipped,
/// so noise cannot make it swing.
class AutoRange {
 public:
  static constexpr int top_range = 3;
  /// Largest |code - middle| that may go up a range: 0.7 x 2047 / 10.
  static constexpr int step_up_peak = 143;

  /// Range to begin a row with. `request`: 0 to 3, or gain_auto.
  int begin(std::uint8_t request) {
    automatic_ = request == protocol::gain_auto;
    came_down_ = false;
    if (!automatic_) return request;
    return range_;
  }
  /// After the lead-in: true if the range changed and the row begins again.
  bool judge_lead_in(int peak, bool clipped) {
    if (clipped) return step_down();
    if (!automatic_ || came_down_ || range_ == top_range || peak > step_up_peak) return false;
    ++range_;
    return true;
  }
  /// A code was clipped: true if a lower range is to be used.
  bool step_down() {
    if (!automatic_ || range_ == 0) return false;
    --range_;
    came_down_ = true;
    return true;
  }
  int range() const { return range_; }

 private:
  int range_ = 0;
  bool automatic_ = false;
  bool came_down_ = false;
};

}  // namespace umov::firmware
