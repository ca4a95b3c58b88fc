// How well the size of a gap is known. Asks nothing of the forward model but what the engine asks.
#pragma once

#include <cstdint>

#include "host/gap/engine/diagnosis.hpp"

namespace umov::gap {

/// Intervals about the sizes in `diagnosis`. Before and after: rows are withheld one at a time
/// (several at a time where there are more than four hundred) and what is foretold of them is drawn
/// anew with replacement, `draws` times. Floor: the spread of the mean square of as many values
/// that hold nothing but noise.
GapBounds gap_bounds(const ForwardModel& model, const Diagnosis& diagnosis, int draws,
                     std::uint64_t seed);

}  // namespace umov::gap
