// A dirty surface beside the linear mixture of its materials: how wrong is mixing by area?
//
// Linear mixing ([C] eq. 7) takes f · contaminant + (1 - f) · bare, f the share of the ground that
// the particles hide along the incident light. The effective fraction is the one with which it
// would give the simulated reflectance.
#pragma once

#include <functional>
#include <vector>

#include "host/surface/scene_file.hpp"
#include "host/trace/simulation.hpp"

namespace umov::surface {

/// Share of light from `theta_i_deg` that each layer of particles meets before anything else but a
/// film; only the samples, seed and threads of `how` count.
std::vector<trace::Estimate> hidden_shares(const Surface& surface, double theta_i_deg,
                                           const trace::Request& how);

struct MixtureBand {
  double wavelength_um;
  trace::Estimate dhr, linear_dhr;
  /// NaN where the contaminant reflects as the bare surface does (within five errors).
  trace::Estimate effective;
  trace::Estimate dop, linear_dop;  ///< hemispherical, of unpolarised light
  /// Root mean square over the hemisphere (weighted by cos θr dΩ) of simulated minus mixed BRDF,
  /// over the mean of the simulated one; the noise is taken out.
  double shape_difference;
};

/// A scene at one angle and one coverage.
struct MixturePoint {
  double theta_i_deg;
  double coverage;            ///< seen from above
  trace::Estimate fraction;   ///< f, seen along the incident light
  trace::Estimate effective;  ///< that fits all wavelengths best (least squares)
  std::vector<MixtureBand> bands;
};

/// `contaminants` and `shares`: one a layer.
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

/// Weighted by the errors of both fractions; γ's own is widened where the points scatter by more
/// than theirs.
MixingLaw fit_law(const std::vector<trace::Estimate>& fraction,
                  const std::vector<trace::Estimate>& effective);

struct MixtureRequest {
  std::vector<double> theta_i_deg;
  std::vector<double> coverage_factors;  ///< of the scene's coverages
  trace::Request how;                    ///< of every simulation but for θi
  std::size_t rings = 18, strip = 180;
  double strip_half_width_deg = 2.0;
  /// Called before each simulation with its number and how many there are.
  std::function<void(std::size_t, std::size_t)> step = {};
};

/// All that was simulated at one angle.
struct MixtureAngle {
  double theta_i_deg;
  trace::Result bare;
  std::vector<trace::Result> contaminants;  ///< by layer
  std::vector<trace::Result> wholes;        ///< by coverage factor
  std::vector<MixturePoint> points;         ///< by coverage factor
  MixingLaw law;                            ///< of MixturePoint::effective
  std::vector<MixingLaw> band_laws;         ///< by wavelength
};

/// `read` describes the scene (read_surface() or surface_from_toml() with the same text). Throws
/// umov::Error for a scene without particles. `how.stop` ends it with the angles that are whole.
std::vector<MixtureAngle> analyse_mixture(const std::function<Surface(const Reading&)>& read,
                                          const MixtureRequest& request);

}  // namespace umov::surface
