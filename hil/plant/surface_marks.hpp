// Peculiarities of a sample's own surface: a smoother part, beads that send light back, a dye, a
// clear coat that interferes, a reflectance that changes along the plate.
//
// - Near-specular lobe: a share of the area is a smoother interface of the same binder, Gaussian
//   facets with Fresnel reflection (P8) of its own small slope.
// - Retroreflection: a Gaussian of the angle to the retro direction, unpolarised, as aberrated
// beads
//   send light back.
// - Fluorescence: excited below 580 nm, emitted above, Lambertian and unpolarised.
// - Clear coat: two-beam interference in a layer of index 1.5 on the facets that mirror, 1 + V
//   cos(4π n d cos θt / λ) (M. Born, E. Wolf, Principles of Optics, §7.5).
// - Gradient: the beam, set on the axis with an error, meets the plate at offset / cos θi.
#pragma once

#include "hil/plant/coating.hpp"

namespace umov::plant {

class MarkedSurface final : public Coating {
 public:
  MarkedSurface(std::shared_ptr<const Sample> below, const MarksConfig& config)
      : Coating(std::move(below)), config_(config) {}

  Mueller brdf(const Beam& in, const Beam& out, double wavelength_nm) const override;
  double emission(const Beam& in, const Beam& out, double wavelength_nm) const override;
  std::shared_ptr<const Sample> with_slopes(double factor) const override;
  std::shared_ptr<const Sample> immersed(double medium_n) const override;

 private:
  MarksConfig config_;
};

}  // namespace umov::plant
