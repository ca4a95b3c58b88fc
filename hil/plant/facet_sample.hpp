// A surface of mirror facets with one of several slope distributions, over a diffuse part.
//
// BRDF = Σ_lobes w D(h) F S / (4 cos θi cos θr) + ρ_d1 + ρ_d2 / (cos θi cos θr) + forward lobe,
// with the Fresnel Mueller matrix of the facet (P8, P9). The distributions differ:
// - gaussian: slopes normal along x and y, of different width where `slope_y` is given
// (anisotropic)
// - ggx: B. Walter, S. R. Marschner, H. Li, K. E. Torrance, EGSR 2007, with its own masking
// - ring: slopes crowd about one steepness, as embossed or crystalline textures have them; a hump
// in
//   the BRDF away from the mirror direction
// Two lobes make a surface of two roughnesses. Masking is the product form of Smith's with the
// slopes along each beam's azimuth. No light is reflected twice.
#pragma once

#include <string>
#include <vector>

#include "hil/plant/sample.hpp"
#include "hil/plant/spectrum.hpp"

namespace umov::plant {

enum class SlopeDistribution { gaussian, ggx, ring };

/// Share of the surface with facets of one kind.
struct FacetLobe {
  SlopeDistribution distribution = SlopeDistribution::gaussian;
  double weight = 1.0;
  double slope = 0.15;     ///< 1-D rms slope; of ggx α/√2; of ring the rms spread of steepness
  double slope_y = 0.0;    ///< across the plane of incidence, gaussian only; 0 = as `slope`
  double steepness = 0.3;  ///< of ring: the slope that facets crowd about
};

struct FacetParameters {
  Spectrum n{1.5}, kappa{0.0};
  std::vector<FacetLobe> lobes{FacetLobe{}};
  Spectrum rho_d1{0.0}, rho_d2{0.0};  ///< 1/sr
  Spectrum forward_per_sr{0.0};       ///< unpolarised Gaussian lobe about the mirror direction …
  double forward_width_deg = 20.0;    ///< … of this rms angle
};

class FacetSample final : public Sample {
 public:
  FacetSample(std::string name, FacetParameters parameters);

  const std::string& name() const override { return name_; }
  Mueller brdf(const Beam& in, const Beam& out, double wavelength_nm) const override;
  std::vector<Truth> truth(double wavelength_nm) const override;
  double feature_width_rad() const override;
  double slope_rms() const override;
  double surface_index(double wavelength_nm) const override;
  std::shared_ptr<const Sample> with_slopes(double factor) const override;
  std::shared_ptr<const Sample> immersed(double medium_n) const override;

  const FacetParameters& parameters() const { return parameters_; }

 private:
  std::string name_;
  FacetParameters parameters_;
  std::vector<double> norm_;  ///< of each lobe's distribution
};

/// D(h) S / (4 cos θi cos θr) of one lobe with weight 1 [1/sr]; `norm` from lobe_norm().
double lobe_factor(const FacetLobe& lobe, double norm, const Vec3& k_i, const Vec3& k_r);
/// What makes the projected facet area of a lobe 1.
double lobe_norm(const FacetLobe& lobe);

}  // namespace umov::plant
