// A dirty surface beside the linear mixture of its materials: how wrong is mixing by area?
//
// Linear mixing ([C] eq. 7) takes f · contaminant + (1 - f) · bare, f the share of the ground that
// the particles hide along the incident light. The effective fraction is the one with which it
// would give the simulated reflectance.
#pragma once

#include <cstdint>
#include <vector>

#include "host/trace/simulation.hpp"

namespace umov::surface {

/// An effective fraction with its whole error and the parts of it: of the simulation of the dirty
/// surface (its lays and rays), and what one standard error of the bare surface's and of the
/// contaminant's simulation moves it by. The latter two are common to all coverages at an angle.
struct EffectiveFraction : trace::Estimate {
  double own = 0.0, by_bare = 0.0, by_contaminant = 0.0;
};

struct MixtureBand {
  double wavelength_um;
  trace::Estimate dhr, linear_dhr;
  /// NaN where the contaminant reflects as the bare surface does (within five errors).
  EffectiveFraction effective;
  trace::Estimate dop, linear_dop;  ///< hemispherical, of unpolarised light
  /// Root mean square over the hemisphere (weighted by cos θr dΩ) of simulated minus mixed BRDF,
  /// over the mean of the simulated one; the noise is taken out.
  double shape_difference;
};

/// A scene at one angle and one coverage.
struct MixturePoint {
  double theta_i_deg;
  double coverage;              ///< seen from above
  trace::Estimate fraction;     ///< f, seen along the incident light
  EffectiveFraction effective;  ///< that fits all wavelengths best (least squares)
  std::uint64_t lays = 1;       ///< behind the errors; 1: these are of rays alone
  std::vector<MixtureBand> bands;
};

/// `contaminants` and `shares`: one a layer. The simulations must be independent (seeds of their
/// own). Where nothing is hidden all layers count alike.
MixturePoint mixed(const trace::Result& whole, const trace::Result& bare,
                   const std::vector<const trace::Result*>& contaminants,
                   const std::vector<trace::Estimate>& shares,
                   const std::vector<double>& wavelengths_um);

/// effective = 1 - (1 - f)^γ: 1 is linear mixing; what particles hide of the ground from light that
/// comes and goes has a γ of 2 and more.
struct MixingLaw {
  double gamma, gamma_u;
  double chi2;          ///< of the points about the law
  int points;           ///< 0: nothing to fit
  double largest_miss;  ///< of a point, in area fraction

  double operator()(double fraction) const;
};

/// Weighted by the errors of both fractions that are each point's own; γ's is widened where the
/// points scatter by more than these, and holds what is common to all points.
MixingLaw fit_law(const std::vector<trace::Estimate>& fraction,
                  const std::vector<EffectiveFraction>& effective);

}  // namespace umov::surface
