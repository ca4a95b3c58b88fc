// Directional-hemispherical reflectance from an in-plane scan at normal incidence (P2).
#pragma once

#include <string>
#include <vector>

#include "host/formats/brdf_table.hpp"

namespace umov::calibrate {

struct DhrOptions {
  double normal_incidence_within_deg = 1.0;
  double min_reach_deg = 60;  ///< smallest largest |θr| that is worth an integral
};

/// Parts of a reflectance's uncertainty, one sigma, absolute.
struct DhrDetail {
  double wavelength_nm = 0, theta_i_deg = 0, dhr = 0;
  double noise_u = 0, shared_u = 0;
  double quadrature_u = 0;   ///< half of the difference between spline and straight-line quadrature
  double extrapolation = 0;  ///< part of dhr from beyond the largest |θr|
  double extrapolation_u = 0;
  double polarisation_u = 0;  ///< only one incident polarisation was measured
  /// Half width of the gap about the normal (way back and mirror direction at once) where points
  /// are marked as unusable; 0 = none. A specular part in there is not in `dhr`.
  double gap_deg = 0;
  double gap_u = 0;    ///< from bridging that gap
  std::string states;  ///< which states the profile was made of
  double u() const;
};

/// Rotates the profile of an isotropic sample about its normal and integrates it. Unpolarised
/// light: the open/open states, or the mean of P and S incidence; with only one of these 2 % of the
/// result is added to the uncertainty. Fills `table.dhr`; nothing where no profile at normal
/// incidence exists.
std::vector<DhrDetail> add_dhr(formats::BrdfTable& table, const DhrOptions& options = {});

/// Weights w with ∫ f cosθ |sinθ| dθ ≈ Σ w f(θ) over [θ_first, θ_last] for the natural cubic spline
/// through the nodes (radians, ascending, signed); `straight` = piecewise straight lines instead.
/// Two nodes or more.
std::vector<double> hemisphere_weights(const std::vector<double>& theta_rad, bool straight);

}  // namespace umov::calibrate
