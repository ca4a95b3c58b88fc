#include "hil/plant/sample.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "hil/plant/quadrature.hpp"
#include "host/errors/error.hpp"

namespace umov::plant {
namespace {

constexpr double pi = optics::pi;

/// Panel edges of [from, to] that crowd about `centre` with finest size `width`.
std::vector<double> panels(double from, double to, double centre, double width) {
  std::vector<double> edges{from, to};
  for (double distance = width; distance < to - from; distance *= 2.0) {
    edges.push_back(centre - distance);
    edges.push_back(centre + distance);
  }
  edges.push_back(centre);
  std::erase_if(edges, [&](double e) { return e < from || e > to; });
  std::sort(edges.begin(), edges.end());
  edges.erase(
      std::unique(edges.begin(), edges.end(), [](double a, double b) { return b - a < 1e-9; }),
      edges.end());
  return edges;
}

}  // namespace

Mueller Sample::mirror(const Beam&, const Beam&, double) const {
  return optics::zero_mueller<double>();
}

std::vector<Truth> Sample::truth(double) const {
  return {};
}

double Sample::emission(const Beam&, const Beam&, double) const {
  return 0.0;
}

double Sample::surface_index(double) const {
  return 1.5;
}

std::shared_ptr<const Sample> Sample::with_slopes(double) const {
  return nullptr;
}

std::shared_ptr<const Sample> Sample::immersed(double) const {
  return nullptr;
}

Mueller brdf_at(const Sample& sample, double theta_i_deg, double theta_r_deg, double phi_r_deg,
                double wavelength_nm) {
  return sample.brdf(optics::incident_beam(optics::radians(theta_i_deg)),
                     optics::exit_beam(optics::radians(theta_r_deg), optics::radians(phi_r_deg)),
                     wavelength_nm);
}

double truth_value(const Sample& sample, const std::string& name, double wavelength_nm) {
  std::string known;
  for (const Truth& truth : sample.truth(wavelength_nm)) {
    if (truth.name == name) return truth.value;
    known += known.empty() ? truth.name : ", " + truth.name;
  }
  throw Error(
      "sample \"" + sample.name() + "\" has no parameter \"" + name + "\"",
      known.empty() ? "this sample is not made from a formula" : "its parameters are " + known);
}

HemisphericalReflectance dhr(const Sample& sample, double theta_i_deg, double wavelength_nm,
                             bool with_mirror) {
  const double theta_i = optics::radians(theta_i_deg);
  const Beam in = optics::incident_beam(theta_i);
  const QuadratureRule& rule = gauss_legendre(10);
  const double width = std::clamp(sample.feature_width_rad(), 0.01, 0.4);
  const auto theta_edges = panels(0.0, pi / 2.0, theta_i, width);
  // The surface is isotropic, so φ and -φ agree. Seen from the normal a lobe at θi has azimuth
  // width/sin θi.
  const double phi_width = std::min(0.8, width / std::max(0.2, std::sin(theta_i)));
  const auto phi_edges = panels(0.0, pi, 0.0, phi_width);
  double m00 = 0.0;
  double m01 = 0.0;
  for (std::size_t a = 0; a + 1 < theta_edges.size(); ++a) {
    const double theta_span = theta_edges[a + 1] - theta_edges[a];
    for (std::size_t i = 0; i < rule.node.size(); ++i) {
      const double theta = theta_edges[a] + theta_span * rule.node[i];
      double ring00 = 0.0;
      double ring01 = 0.0;
      for (std::size_t b = 0; b + 1 < phi_edges.size(); ++b) {
        const double phi_span = phi_edges[b + 1] - phi_edges[b];
        for (std::size_t j = 0; j < rule.node.size(); ++j) {
          const double phi = phi_edges[b] + phi_span * rule.node[j];
          const Mueller m = sample.brdf(in, optics::exit_beam(theta, phi), wavelength_nm);
          ring00 += 2.0 * phi_span * rule.weight[j] * optics::element(m, 0, 0);
          ring01 += 2.0 * phi_span * rule.weight[j] * optics::element(m, 0, 1);
        }
      }
      const double weight = theta_span * rule.weight[i] * std::cos(theta) * std::sin(theta);
      m00 += weight * ring00;
      m01 += weight * ring01;
    }
  }
  if (with_mirror) {
    const Mueller m = sample.mirror(in, optics::exit_beam(theta_i, 0.0), wavelength_nm);
    m00 += optics::element(m, 0, 0);
    m01 += optics::element(m, 0, 1);
  }
  return {m00, m00 + m01, m00 - m01};
}

}  // namespace umov::plant
