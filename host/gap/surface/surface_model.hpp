// A measured BRDF of a dirty, wet or rough surface against what is usually made of one: materials
// mixed by area, each bounced off once, dry. What that leaves out are the effects.
//
// Everything is simulated from the surface's scene file at a few coverages; the diagnosis then
// moves between these simulations.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "host/formats/brdf_table.hpp"
#include "host/gap/engine/forward_model.hpp"

namespace umov::gap {

struct SurfaceModelOptions {
  std::uint64_t seed = 1;
  int threads = 0;
  std::uint64_t samples = 1u << 20;  ///< launches of each simulation
  /// Simulated coverages, as multiples of the scene's; four or fewer, ascending. One where the
  /// scene has no particles.
  std::vector<double> coverage_factors{0.5, 0.8, 1.1, 1.4};
  std::size_t rings = 18;                     ///< cells of directions out of the plane of incidence
  std::function<void(double)> progress = {};  ///< share of the simulations that are done
};

/// Base: `gain`, and `area_scale` (coverage over that of the scene) where it has particles; the
/// linear mixture of bare ground and flat contaminant in single bounce. Effects:
/// particle_shadowing (particles stand up: they hide and shade), multiple_scattering (between
/// faces), water_film (where the scene has none and its models can be wet), contaminant_albedo
/// (with all that particles do, where they are Lambertian), ground_albedo, near_specular_lobe.
class SurfaceModel : public ForwardModel {
 public:
  /// `scene` is the text of a scene file, `name` stands in errors. Observations are the Mueller
  /// elements m00 and m10 of the measurement, or its points without polariser and analyser; those
  /// with φ = 0 are compared in the plane of incidence, others with the cell they lie in. Throws
  /// umov::Error for a measurement without any, for wavelengths that the scene has not, and for
  /// whatever the scene file refuses.
  SurfaceModel(const formats::BrdfTable& measurement, const std::string& scene,
               const std::string& name, const SurfaceModelOptions& options = {});

  const Observations& observations() const override { return observations_; }
  const std::vector<Parameter>& base() const override { return base_; }
  const std::vector<Effect>& effects() const override { return effects_; }
  void predict(const Explanation& explanation, Eigen::VectorXd& mean, Eigen::MatrixXd* jacobian,
               const std::vector<bool>& wanted = {}) const override;
  bool is_quick() const override { return true; }
  NoiseShape noise(const Eigen::VectorXd& mean) const override;

 private:
  /// Of all observations at the coverages of `factors_`; one column each.
  using Series = Eigen::MatrixXd;
  Eigen::VectorXd at(const Series& series, double area_scale) const;

  std::vector<double> factors_;
  Series linear_;                  ///< the base at gain 1
  std::vector<Series> templates_;  ///< by effect: what one unit of it adds
  Eigen::VectorXd sigma_;
  Observations observations_;
  std::vector<Parameter> base_;
  std::vector<Effect> effects_;
};

}  // namespace umov::gap
