#include "hil/plant/diffuser_sample.hpp"

#include <cmath>
#include <cstddef>
#include <utility>

#include "hil/plant/quadrature.hpp"
#include "hil/plant/rough_surface.hpp"
#include "host/optics/fresnel.hpp"

namespace umov::plant {
namespace {

constexpr double pi = optics::pi;

double surface_dhr_at_normal(const DiffuserParameters& parameters) {
  if (parameters.surface == 0.0) return 0.0;
  const QuadratureRule& rule = gauss_legendre(96);
  const Vec3 down(0.0, 0.0, -1.0);
  double sum = 0.0;
  for (std::size_t i = 0; i < rule.node.size(); ++i) {
    const double theta = 0.5 * pi * rule.node[i];
    const Vec3 k(std::sin(theta), 0.0, std::cos(theta));
    sum += rule.weight[i] * 0.5 * pi * 2.0 * pi * std::sin(theta) * std::cos(theta) *
           facet_factor(parameters.surface_slope, down, k) *
           optics::reflectance(parameters.surface_n, 0.0, facet_cosine(down, k));
  }
  return parameters.surface * sum;
}

}  // namespace

DiffuserSample::DiffuserSample(std::string name, DiffuserParameters parameters)
    : name_(std::move(name)),
      parameters_(std::move(parameters)),
      surface_dhr_(surface_dhr_at_normal(parameters_)) {}

double DiffuserSample::volume_norm(double wavelength_nm) const {
  // 2∫h cos θ sin θ dθ = 1 - roll_off/3, and h(0) = 1.
  return (parameters_.dhr.at(wavelength_nm) - surface_dhr_) / (1.0 - parameters_.roll_off / 3.0);
}

Mueller DiffuserSample::brdf(const Beam& in, const Beam& out, double wavelength_nm) const {
  Mueller m = optics::zero_mueller<double>();
  const double cos_i = -in.k.z;
  const double cos_r = out.k.z;
  if (cos_i <= 0.0 || cos_r <= 0.0) return m;
  const double h_i = 1.0 - parameters_.roll_off * (1.0 - cos_i);
  const double h_r = 1.0 - parameters_.roll_off * (1.0 - cos_r);
  const double volume = volume_norm(wavelength_nm) / pi * h_i * h_r;
  if (parameters_.kept != 0.0) {
    Mueller in_plane = optics::zero_mueller<double>();
    optics::set_element(in_plane, 1, 1, 1.0);
    optics::set_element(in_plane, 2, 2, -1.0);
    optics::set_element(in_plane, 3, 3, -1.0);
    m += volume * parameters_.kept *
         optics::to_beam_bases(in_plane, in, out, optics::scattering_plane_normal(in, out));
  }
  if (parameters_.surface != 0.0) {
    m += parameters_.surface * facet_factor(parameters_.surface_slope, in.k, out.k) *
         facet_reflection(parameters_.surface_n, 0.0, in, out);
  }
  optics::set_element(m, 0, 0, optics::element(m, 0, 0) + volume);
  return m;
}

double DiffuserSample::slope_rms() const {
  return parameters_.surface > 0.0 ? parameters_.surface_slope : 0.0;
}

double DiffuserSample::surface_index(double) const {
  return parameters_.surface_n;
}

std::shared_ptr<const Sample> DiffuserSample::with_slopes(double factor) const {
  if (parameters_.surface == 0.0) return nullptr;
  DiffuserParameters changed = parameters_;
  changed.surface_slope *= factor;
  return std::make_shared<DiffuserSample>(name_, std::move(changed));
}

std::vector<Truth> DiffuserSample::truth(double wavelength_nm) const {
  return {{"dhr", parameters_.dhr.at(wavelength_nm), "1"},
          {"roll_off", parameters_.roll_off, "1"},
          {"kept", parameters_.kept, "1"},
          {"surface", parameters_.surface, "1"},
          {"surface_n", parameters_.surface_n, "1"},
          {"surface_slope", parameters_.surface_slope, "1"}};
}

}  // namespace umov::plant
