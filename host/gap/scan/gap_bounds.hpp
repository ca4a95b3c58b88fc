// How well the size of a gap is known. Asks nothing of the forward model but what the engine asks.
#pragma once

#include <cstdint>

#include "host/gap/engine/diagnosis.hpp"

namespace umov::gap::scan {

/// 95 % intervals of a gap's size.
struct GapInterval {
  Interval g2, percent;
};

struct GapBounds {
  GapInterval before, after, floor;
};

/// Intervals about the sizes in `diagnosis`, whose final explanation is `after`. Before and after:
/// rows are withheld one at a time (several at a time where there are more than four hundred) and
/// what is foretold of them is drawn anew with replacement, `draws` times. Floor: the spread of the
/// mean square of as many values that hold nothing but noise.
GapBounds gap_bounds(const ForwardModel& model, const Diagnosis& diagnosis, const Refit& after,
                     int draws, std::uint64_t seed);

}  // namespace umov::gap::scan
