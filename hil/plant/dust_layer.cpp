#include "hil/plant/dust_layer.hpp"

#include <cmath>

namespace umov::plant {
namespace {

/// Mean 1 over the sphere.
double henyey_greenstein(double g, double cosine) {
  return (1.0 - g * g) / std::pow(1.0 + g * g - 2.0 * g * cosine, 1.5);
}

}  // namespace

double DustLayer::transmitted(double cos_i, double cos_r, double wavelength_nm) const {
  if (cos_i <= 0.0 || cos_r <= 0.0) return 0.0;
  const double depth = config_.optical_depth_633 * 633.0 / wavelength_nm;
  return std::exp(-depth * (1.0 / cos_i + 1.0 / cos_r));
}

Mueller DustLayer::brdf(const Beam& in, const Beam& out, double wavelength_nm) const {
  const double cos_i = -in.k.z;
  const double cos_r = out.k.z;
  if (cos_i <= 0.0 || cos_r <= 0.0) return optics::zero_mueller<double>();
  const double passed = transmitted(cos_i, cos_r, wavelength_nm);
  Mueller m = passed * below().brdf(in, out, wavelength_nm);
  const double scattered = config_.single_scattering_albedo *
                           henyey_greenstein(config_.g, optics::dot(in.k, out.k)) /
                           (4.0 * optics::pi * (cos_i + cos_r)) * (1.0 - passed);
  optics::set_element(m, 0, 0, optics::element(m, 0, 0) + scattered);
  return m;
}

Mueller DustLayer::mirror(const Beam& in, const Beam& out, double wavelength_nm) const {
  return transmitted(-in.k.z, out.k.z, wavelength_nm) * below().mirror(in, out, wavelength_nm);
}

double DustLayer::emission(const Beam& in, const Beam& out, double wavelength_nm) const {
  return transmitted(-in.k.z, out.k.z, wavelength_nm) * below().emission(in, out, wavelength_nm);
}

}  // namespace umov::plant
