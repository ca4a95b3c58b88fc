// Where particles lie: discs that do not overlap, at random over a square that repeats.
#pragma once

#include <cstdint>
#include <vector>

namespace umov::surface {

struct Disc {
  double x, y, radius;
};

/// Diameters with a log-normal distribution: `median`, and `spread` (>= 1), the factor of one
/// standard deviation; cut off at two of them.
struct Sizes {
  double median;
  double spread = 1.0;
};

/// Adds discs of `sizes` to those in `placed` until they cover `coverage` of the square of `size`,
/// as nearly as whole discs can; large ones first, each at the first free place of those tried at
/// random. The centres are in [0, size). `seed` decides all.
///
/// Throws umov::Error for coverages not above 0 or from 1 on, discs wider than half the square, and
/// where the discs find no room: equal discs at random cover at most about half of a plane.
void scatter(std::vector<Disc>& placed, const Sizes& sizes, double coverage, double size,
             std::uint64_t seed);

}  // namespace umov::surface
