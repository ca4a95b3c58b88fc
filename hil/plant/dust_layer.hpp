// A thin layer of dust on a sample.
//
// Light passes the layer twice and is thinned by exp(-τ(1/cos θi + 1/cos θr)); the layer scatters a
// part of it straight to the detector: single scattering of a plane layer with the phase function
// of Henyey & Greenstein (S. Chandrasekhar, Radiative Transfer, 1950, §47; L. G. Henyey, J. L.
// Greenstein, Astrophys. J. 93, 70 (1941)),
//     ϖ P(Θ) / (4π (cos θi + cos θr)) · (1 - exp(-τ(1/cos θi + 1/cos θr))).
// τ goes with 1/λ, as the extinction of particles of about a wavelength does (Ångström exponent 1).
// Scattered light is unpolarised. Left out: light that meets both dust and sample, and light
// scattered twice by the dust; of second order in τ on a dark sample.
#pragma once

#include "hil/plant/coating.hpp"

namespace umov::plant {

class DustLayer final : public Coating {
 public:
  DustLayer(std::shared_ptr<const Sample> below, const DustConfig& config)
      : Coating(std::move(below)), config_(config) {}

  Mueller brdf(const Beam& in, const Beam& out, double wavelength_nm) const override;
  Mueller mirror(const Beam& in, const Beam& out, double wavelength_nm) const override;
  double emission(const Beam& in, const Beam& out, double wavelength_nm) const override;

 private:
  /// Both passages together; 0 where a beam is below the horizon.
  double transmitted(double cos_i, double cos_r, double wavelength_nm) const;

  DustConfig config_;
};

}  // namespace umov::plant
