#include "hil/plant/mirror_sample.hpp"

#include <utility>

#include "hil/plant/rough_surface.hpp"

namespace umov::plant {

MirrorSample::MirrorSample(std::string name, optics::IndexTable index)
    : name_(std::move(name)), index_(std::move(index)) {}

Mueller MirrorSample::brdf(const Beam&, const Beam&, double) const {
  return optics::zero_mueller<double>();
}

Mueller MirrorSample::mirror(const Beam& in, const Beam& out, double wavelength_nm) const {
  if (in.k.z >= 0.0) return optics::zero_mueller<double>();
  const double um = wavelength_nm * 1e-3;
  return facet_reflection(index_.n(um), index_.kappa(um), in, out);
}

std::vector<Truth> MirrorSample::truth(double wavelength_nm) const {
  const double um = wavelength_nm * 1e-3;
  return {{"n", index_.n(um), "1"}, {"kappa", index_.kappa(um), "1"}};
}

}  // namespace umov::plant
