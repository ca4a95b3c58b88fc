// What is known of the bench from elsewhere (data sheets, alignment) and no scan of a campaign
// shows: declared standard uncertainties (GUM type B) and what they do to the points of a scan.
#pragma once

#include <vector>

#include "host/formats/brdf_table.hpp"

namespace umov::calibrate {

/// One standard deviation each; 0 = not declared.
struct DeclaredDoubts {
  double theta_i_zero_u_deg = 0;  ///< zero of the incidence arm
  double theta_r_zero_u_deg = 0;  ///< zero of the detector arm
  /// Half-angle of the detector disc seen from the sample: a BRDF that curves within it is
  /// averaged.
  double aperture_half_angle_deg = 0;
  /// Of the detector's solid angle, relative: matters only where a scan's differs from the
  /// standard's.
  double solid_angle_relative_u = 0;
};

/// How the points of a scan change with angles: derivatives of f cosθr (what the detector sees) by
/// the true angle, from the neighbouring points of the same state. All in 1/sr per degree, a point
/// each; zero where there are no neighbours.
struct AngleSlopes {
  /// d(f cosθr)/dθr / cosθr.
  std::vector<double> detector;
  /// df/dθi: along lines of constant θr - θi from the neighbouring incidences, minus df/dθr, which
  /// is what moves a lobe about the mirror direction.
  std::vector<double> incidence;
  /// d²f/dθr², 1/sr per square degree.
  std::vector<double> curvature;
};

AngleSlopes angle_slopes(const formats::BrdfTable::Points& points);

}  // namespace umov::calibrate
