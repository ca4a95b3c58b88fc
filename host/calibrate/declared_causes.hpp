// The declared doubts of a bench, one cause each: what one standard deviation does to points.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "host/calibrate/calibration.hpp"
#include "host/calibrate/point_factors.hpp"
#include "host/formats/brdf_table.hpp"

namespace umov::calibrate {

struct DeclaredCause {
  std::string name;
  std::vector<double> own_per_sr;  ///< shift of the points themselves; empty: none
  /// Number of the calibration's systematic quantity that goes with it: the standard was measured
  /// with the same error.
  std::optional<std::size_t> through_standard = std::nullopt;
};

/// Of the doubts that are declared, by name: "detector zero", "detector eccentricity 1" (cosine)
/// and "2" (sine), "detector play", "standard lean", "sample lean", "incidence zero", "detector
/// stop 30" and "incidence stop 30" for each angle that a drive stopped at, "source 532 nm" and,
/// for each incidence, "source 532 nm 30", "solid angle"; and "aperture", the doubt of its
/// correction.
std::vector<DeclaredCause> declared_causes(const formats::BrdfTable::Points& points,
                                           const std::vector<PointOrigin>& origin,
                                           const Calibration& calibration);

}  // namespace umov::calibrate
