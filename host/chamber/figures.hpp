// Figures of merit: how alike two luminance maps or two distributions are, how even and how
// glaring one is.
#pragma once

#include <cstddef>
#include <functional>
#include <utility>
#include <vector>

#include "host/chamber/camera.hpp"
#include "host/chamber/goniophotometer.hpp"

namespace umov::chamber {

/// Part of a map, in mm from its lower left corner.
struct Region {
  double x_from_mm, x_to_mm, y_from_mm, y_to_mm;
};

/// The pixels whose centres lie inside, as a map of its own, of luminance alone. Throws umov::Error
/// where there are none.
Map cut(const Map& map, const Region& region);

/// The luminance of the map with `n` × `n` pixels to one, from the lower left: means, and their
/// standard errors from those of the pixels as independent ones. What fills no whole pixel at the
/// upper and right edge is left out. Throws umov::Error where nothing is left.
Map joined(const Map& map, std::size_t n);

/// Of one map.
struct Evenness {
  double maximum, mean, minimum;
  double uniformity;  ///< minimum/mean
};
Evenness evenness(const Map& map);

/// Of two maps of equal size.
struct Likeness {
  double ncc;             ///< −1 to 1; 0 where a map is flat
  double nrmse;           ///< √(mean (a − b)²)/max(a, b)
  double mean_deviation;  ///< mean |a − b|/max(a, b): [M]'s printed formula with its 1/N
};
/// Throws umov::Error for maps of different sizes.
Likeness likeness(const Map& a, const Map& b);

/// The luminance of `map` moved by (x, y) pixels, bilinear, edge values repeated.
Map moved(const Map& map, double x_pixels, double y_pixels);
/// The move of `b`, up to `reach` pixels in x and y, that makes the NCC with `a` largest, found to
/// 0.05 pixels; and what likeness is then.
struct Registration {
  double x_pixels, y_pixels;
  Likeness likeness;
};
Registration registered(const Map& a, const Map& b, double reach);

/// Largest difference of two distributions on the same directions over the largest intensity of
/// `a`, in one C plane and its opposite (number of the plane), or in all where `plane` is negative;
/// and its root mean square.
struct DistributionDifference {
  double largest, rms;
};
DistributionDifference difference(const Distribution& a, const Distribution& b, int plane = -1);

/// Unified glare rating (CIE 117): 8 lg(0.25/Lb Σ L²ω/p²).
struct Glare {
  double background_cd_m2 = 40.0;
  double observer_distance_m = 2.0;
  double position_index = 1.0;
};
/// Of one luminaire seen as in the map. `ugr_uniform` takes the opening as evenly bright, as from
/// intensity over area; `ugr_map` sums over pixels. Pixels of less than 500 cd/m² count all the
/// same: the threshold of CIE 232 is not applied.
struct GlareRating {
  double ugr_map, ugr_uniform;
};
GlareRating glare_rating(const Map& map, const Glare& glare);

}  // namespace umov::chamber
