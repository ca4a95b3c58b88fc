// A BRDF as averages over pairs of Klems patches: the matrix of a Window-6 XML, and how it is made.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "host/formats/klems_basis.hpp"

namespace umov::formats {

/// `values[exit * incident.size() + incident]` in 1/sr: the mean of the BRDF over both patches,
/// weighted with cos θi cos θr. Not multiplied by a cosine.
///
/// The number of an incident patch tells where the light **travels to**, seen from above: light of
/// incident patch p comes from azimuth φp + 180 deg, so that a mirror sends it into exit patch p
/// and its matrix is diagonal.
struct KlemsMatrix {
  KlemsBasis incident, exit;
  std::vector<double> values;

  double& at(std::size_t exit_patch, std::size_t incident_patch) {
    return values[exit_patch * incident.size() + incident_patch];
  }
  double at(std::size_t exit_patch, std::size_t incident_patch) const {
    return values[exit_patch * incident.size() + incident_patch];
  }
};

/// Directional-hemispherical reflectance of each incident patch (mean over the patch):
/// Σ value × projected solid angle of the exit patch.
std::vector<double> directional_hemispherical(const KlemsMatrix& matrix);

/// How far a matrix is from one of an isotropic surface: turning the sample by a common multiple of
/// both rings' patch widths, or looking at it in a mirror, must change nothing. Mean of the
/// |differences| in reflected power over the mean reflected power; 0 for an isotropic surface.
double anisotropy(const KlemsMatrix& matrix);

/// What is averaged. Angles in radians, φ = 0 forward; results in 1/sr and 1.
struct KlemsSource {
  std::function<double(double theta_i, double theta_r, double phi_r)> brdf;
  /// Share that leaves exactly in the mirror direction; none where empty.
  std::function<double(double theta_i)> mirror;
};

struct KlemsAverage {
  KlemsMatrix matrix;
  /// Largest estimated error of a value, over max(value, 0.001/sr).
  double largest_relative_error = 0;
};

/// Averages an isotropic source over all pairs of patches by adaptive cubature. Each value is
/// refined until its estimated error is below `relative_accuracy` of it or below 1e-6/sr. Lobes
/// whose half width is below .05 deg may be missed by the first subdivision. Throws umov::Error
/// where the source is negative or not a number.
KlemsAverage klems_average(const KlemsSource& source, const KlemsBasis& basis,
                           double relative_accuracy = 1e-3,
                           const std::function<void(double done, double total)>& progress = {});

}  // namespace umov::formats
