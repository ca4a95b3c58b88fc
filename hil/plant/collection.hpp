// From the beam on the sample to the light on the detector: true directions, apertures, losses.
#pragma once

#include "hil/plant/plant_config.hpp"
#include "hil/plant/sample.hpp"

namespace umov::plant {

/// True angles of the stages, radians. θr signed, φ the azimuth of the detector's plane.
struct Geometry {
  double theta_i = 0.0;
  double theta_r = 0.0;
  double phi_r = 0.0;
  /// Deviations by wedges: of the beam and of the detector's line of sight, towards the p and the s
  /// axis of their bases.
  double steer_in_p = 0.0, steer_in_s = 0.0;
  double steer_out_p = 0.0, steer_out_s = 0.0;

  bool operator==(const Geometry&) const = default;
};

/// Changes of the set-up that an operator makes between parts of a scan.
struct Setup {
  double sample_azimuth_deg = 0.0;  ///< sample turned in its mount, about its own normal
  double iris_fraction = 1.0;       ///< detector aperture's diameter over its usual one
  bool sample_removed = false;
  double sample_shift_mm = 0.0;  ///< sample pushed along its plate: other speckle
  bool long_pass = false;        ///< filter before the detector, see LongPassConfig
};

/// Mueller matrices between the polariser's basis and the analyser's: power into the detector per
/// power in the beam. Both factors are dimensionless.
struct Throughput {
  Mueller diffuse;  ///< ⟨f cos θr⟩ ΔΩ, stray light included
  Mueller mirror;   ///< mirror reflectance times the part of the mirrored beam inside the aperture
  double emitted = 0.0;  ///< unpolarised light at longer wavelengths that the beam excites
  Mueller total() const { return diffuse + mirror; }
};

/// Averages the sample over detector disc, beam divergence and line width with the true directions
/// of each ray; the analyser's axis is projected on each ray. Tilts, overfill, field of view,
/// filter ghost and occlusion included.
Throughput collect(const Sample& sample, const PlantConfig& config, const Setup& setup,
                   const Geometry& geometry, double wavelength_nm, double line_width_nm);

/// Share of a centred elliptic Gaussian (rms along x and y) inside the ellipse with half-axes
/// `half_x`, `half_y`, the ellipse turned by `turn` radians.
double gaussian_in_ellipse(double rms_x, double rms_y, double half_x, double half_y, double turn);

/// Share of a circular Gaussian of `rms` centred at distance `offset` from the centre of a disc of
/// `radius`.
double gaussian_in_disc(double rms, double offset, double radius);

/// Share of a disc of radius `a` that a disc of radius `b` at centre distance `d` covers; for a = 0
/// it is 1 or 0.
double disc_overlap(double a, double b, double d);

}  // namespace umov::plant
