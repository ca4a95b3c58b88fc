// Where particles lie: discs seen from above, on a square that repeats.
#pragma once

#include <cstdint>
#include <vector>

namespace umov::surface {

struct Disc {
  double x, y, radius;
  bool may_overlap = false;
};

/// Diameters with a log-normal distribution: `median`, and `spread` (>= 1), the factor of one
/// standard deviation; cut off at two of them.
struct Sizes {
  double median;
  double spread = 1.0;
};

/// random: each anywhere. poisson_disk: at random, but well apart. cluster: about random centres
/// (Neyman and Scott 1958). grid: rows and columns.
enum class Layout { random, poisson_disk, cluster, grid };

/// How one kind of particles is laid.
struct Laying {
  Sizes sizes;
  double coverage;  ///< area seen from above over that of the ground, above 0 and up to .95
  Layout layout = Layout::random;
  /// Particles may overlap in plan, others of the same kind and of other kinds; coverage is then
  /// that of what they cover together. Without it none overlaps another.
  bool overlap = false;
  double cluster_size = 10.0;   ///< cluster: particles a centre, in the mean
  double cluster_radius = 0.0;  ///< cluster: one standard deviation; 0: half a diameter
                                ///< times √cluster_size
};

/// Adds discs to those in `placed` until they cover the area asked for, as nearly as whole discs
/// can; centres are in [0, size). Up to half of the ground each disc in its turn gets the first
/// free place of those drawn at random; beyond, all of a layer are drawn and pushed apart, which
/// moves earlier ones too. `seed` decides all. How many steps that took: a disc that tries a place
/// or is pushed, some .2 µs.
///
/// Throws umov::Error for values out of range, discs wider than half the square, and where the
/// discs find no room: equal ones without overlap cover about .8 at random and .78 on a grid.
std::uint64_t lay(std::vector<Disc>& placed, const Laying& laying, double size, std::uint64_t seed);

/// Share of the square that the discs cover together, from 2048² points.
double covered_share(const std::vector<Disc>& discs, double size);

}  // namespace umov::surface
