// A paint: rough binder surface over a scattering, absorbing layer (P11).
//
// BRDF = k_dd f_dd + k_udf/π + k_uds/π T(θi)T(θr)/(T(0) T̄) + k_fs f_fs. The directional term keeps
// the Fresnel Mueller matrix, the forward lobe part of the polarisation, the two uniform terms
// none. Not energy conserving by construction: parameters are chosen so that it is (checked for the
// shipped paints).
#pragma once

#include <string>
#include <vector>

#include "hil/plant/rough_surface.hpp"
#include "hil/plant/sample.hpp"
#include "hil/plant/spectrum.hpp"

namespace umov::plant {

/// Parameters of P11, each a function of wavelength where it may be one.
struct PaintParameters {
  Spectrum n{1.5};                ///< refractive index of the binder
  Spectrum kappa{0.0};            ///< its extinction index
  double sigma_um = 1.0;          ///< rms height σ0
  double tau_um = 20.0;           ///< autocorrelation length
  Spectrum k_dd{1.0};             ///< weight of the directional-diffuse term
  Spectrum k_udf{0.0};            ///< first-surface uniform diffuse
  Spectrum k_uds{0.0};            ///< subsurface uniform diffuse
  Spectrum k_fs{0.0};             ///< forward-scattered lobe
  Spectrum fs_polarization{0.0};  ///< a, the part of the polarisation it keeps, 0 … 1
  double fs_width_deg = 10.0;     ///< w, rms angle of the forward lobe
};

class PaintSample final : public Sample {
 public:
  PaintSample(std::string name, PaintParameters parameters);

  const std::string& name() const override { return name_; }
  Mueller brdf(const Beam& in, const Beam& out, double wavelength_nm) const override;
  Mueller mirror(const Beam& in, const Beam& out, double wavelength_nm) const override;
  std::vector<Truth> truth(double wavelength_nm) const override;
  double feature_width_rad() const override;
  double slope_rms() const override;
  double surface_index(double wavelength_nm) const override;
  std::shared_ptr<const Sample> with_slopes(double factor) const override;
  std::shared_ptr<const Sample> immersed(double medium_n) const override;

 private:
  std::string name_;
  PaintParameters parameters_;
  HeightStatistics surface_;
  double fs_width_rad_ = 0.0;
  double fs_norm_ = 1.0;  ///< N(w): cosine-weighted integral of the lobe at normal incidence
};

/// T̄ = 2∫T cos θ sin θ dθ: unpolarised transmittance of a smooth interface under uniform
/// illumination.
double mean_transmittance(double n, double kappa);

}  // namespace umov::plant
