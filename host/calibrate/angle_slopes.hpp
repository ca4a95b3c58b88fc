// How the points of a scan change with the angles they were taken at.
#pragma once

#include <functional>
#include <vector>

#include "host/formats/brdf_table.hpp"

namespace umov::calibrate {

/// A BRDF between and beside the points of a scan, such as a fitted model's, 1/sr: θi, θr (signed
/// in plane), φr in degrees, wavelength in nm, axes of polariser and analyser in degrees (open_axis
/// = open). Only its course counts, not its level.
using BrdfShape =
    std::function<double(double theta_i_deg, double theta_r_deg, double phi_r_deg,
                         double wavelength_nm, double polarizer_deg, double analyzer_deg)>;

/// Derivatives of f cosθr (what the detector sees) by the true angle. All in 1/sr per degree, a
/// point each; zero where nothing tells them.
struct AngleSlopes {
  /// d(f cosθr)/dθr / cosθr.
  std::vector<double> detector;
  /// df/dθi.
  std::vector<double> incidence;
  /// df/dθr, and d²f/dθr² in 1/sr per square degree.
  std::vector<double> slope, curvature;
};

/// From the neighbouring points of the same state: parabolas through ln f where the noise allows,
/// else through f. By θi it is, of two ways through the neighbouring incidences, the one along
/// which the BRDF changes less: that on which a lobe stays in place (constant θr - θi), or that of
/// constant θr. With incidences 15° apart this is good to some .01 a degree.
AngleSlopes angle_slopes(const formats::BrdfTable::Points& points);

/// From a shape, exactly; its level is that of each point.
AngleSlopes angle_slopes(const formats::BrdfTable::Points& points, const BrdfShape& shape);

}  // namespace umov::calibrate
