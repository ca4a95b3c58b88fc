// The detector is a disc and no point: what it adds to a BRDF that curves within it (P27).
#pragma once

#include <cstddef>
#include <vector>

#include "host/calibrate/angle_slopes.hpp"
#include "host/formats/brdf_table.hpp"

namespace umov::calibrate {

struct ApertureExcess {
  /// Mean of f cosθr over the disc divided by the cosine of its middle, minus f there; 1/sr, a
  /// point each. Zero where it cannot be known: fewer than three exit angles, or `too_narrow`.
  std::vector<double> per_sr;
  /// One standard deviation of it, with its sign; the bound where `too_narrow`.
  std::vector<double> doubt_per_sr;
  /// Used points at which the excess exceeds a quarter of the BRDF: a lobe as narrow as the disc,
  /// whose shape within it these points do not know.
  std::size_t too_narrow = 0;
};

/// From the neighbouring points, to second order in the half-angle. In the plane of incidence the
/// curvature is that of the points. Across it, the BRDF is taken to go with the angle θh between
/// the normal and the half vector, as a lobe of facets does: f'(θr)/(2 tanθh cos²θd), f''/cos²θd at
/// its middle. The doubt is a fifth, and more where higher orders count.
ApertureExcess aperture_excess(const formats::BrdfTable::Points& points, const AngleSlopes& slopes,
                               double half_angle_deg);

/// By averaging a shape over the disc. The doubt is a twentieth: how round the disc is and how much
/// the beam itself spreads.
ApertureExcess aperture_excess(const formats::BrdfTable::Points& points, const BrdfShape& shape,
                               double half_angle_deg);

}  // namespace umov::calibrate
