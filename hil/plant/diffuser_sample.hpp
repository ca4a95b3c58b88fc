// White tiles and ideal diffusers.
#pragma once

#include <string>
#include <vector>

#include "hil/plant/sample.hpp"
#include "hil/plant/spectrum.hpp"

namespace umov::plant {

/// A sintered-polymer tile in the spirit of the measured PTFE standards: volume scatter whose
/// radiance falls a little towards grazing at both ends, of which a small part keeps polarisation,
/// and a weak very rough first surface that adds polarised forward scatter at large angles. With
/// `roll_off`, `kept` and `surface` zero it is Lambertian.
struct DiffuserParameters {
  Spectrum dhr{0.99};     ///< DHR of unpolarised light at normal incidence, all parts together
  double roll_off = 0.0;  ///< h(θ) = 1 - roll_off·(1 - cos θ), a factor at either end
  double kept =
      0.0;  ///< part of the volume scatter with Mueller matrix diag(1, 1, -1, -1) in plane
  double surface = 0.0;     ///< weight of the first surface, 1 = a full Gaussian-facet surface (P8)
  double surface_n = 1.35;  ///< its refractive index
  double surface_slope = 0.5;  ///< its 1-D rms slope
};

class DiffuserSample final : public Sample {
 public:
  DiffuserSample(std::string name, DiffuserParameters parameters);

  const std::string& name() const override { return name_; }
  Mueller brdf(const Beam& in, const Beam& out, double wavelength_nm) const override;
  std::vector<Truth> truth(double wavelength_nm) const override;
  double slope_rms() const override;
  double surface_index(double wavelength_nm) const override;
  std::shared_ptr<const Sample> with_slopes(double factor) const override;

 private:
  double volume_norm(double wavelength_nm) const;

  std::string name_;
  DiffuserParameters parameters_;
  double surface_dhr_ = 0.0;  ///< of the first surface at normal incidence
};

}  // namespace umov::plant
