#include "host/chamber/synthetic_mcpet.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "host/brdf/dhr.hpp"
#include "host/brdf/evaluate.hpp"
#include "host/optics/angles.hpp"

namespace umov::chamber {
namespace {

using optics::radians;

constexpr double wavelength_um = 0.555;
constexpr double mcpet_alpha = 0.1;

struct Plastic {
  brdf::Model model = brdf::Model::by_name("ggx+subsurface");
  std::vector<double> values;

  explicit Plastic(double alpha = mcpet_alpha) {
    for (const brdf::Parameter& p : model.parameters()) values.push_back(p.initial);
    set("0.n", 1.6);
    set("0.alpha", alpha);
    set("1.n", 1.6);
    set("1.rho", 0.9942);
  }
  void set(std::string_view name, double value) {
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (model.parameters()[i].name == name) values[i] = value;
    }
  }
  double brdf(const brdf::Geometry<double>& geometry) const {
    return brdf::evaluate<double>(model, values, wavelength_um, geometry)[0][0];
  }
  /// Scales an incidence to reflect `total`.
  double scale(double theta_i_deg, double total = mcpet_total) const {
    return total / brdf::dhr(model, values, wavelength_um, radians(theta_i_deg)).unpolarized;
  }
};

/// Direction at angle β from the mirror direction in the plane across.
brdf::Geometry<double> across(double theta_i, double beta) {
  const double x = std::sin(theta_i) * std::cos(beta);
  const double y = std::sin(beta);
  const double z = std::cos(theta_i) * std::cos(beta);
  return {theta_i, std::atan2(std::hypot(x, y), z), std::atan2(y, x)};
}

}  // namespace

brdf::PlanesTable synthetic_mcpet(std::span<const double> theta_i_deg, double step_deg) {
  return synthetic_plastic(mcpet_alpha, theta_i_deg, step_deg);
}

brdf::PlanesTable synthetic_plastic(double alpha, std::span<const double> theta_i_deg,
                                    double step_deg, double total) {
  const Plastic plastic(alpha);
  std::vector<brdf::PlanesAtIncidence> incidences;
  for (const double incidence : theta_i_deg) {
    brdf::PlanesAtIncidence slice;
    slice.theta_i_deg = incidence;
    const double theta = radians(incidence);
    const double scale = plastic.scale(incidence, total);
    slice.in_plane.brdf_per_sr.resize(1);
    slice.across.brdf_per_sr.resize(1);
    const int last = static_cast<int>(std::ceil(90.0 / step_deg)) - 1;
    for (int i = -last; i <= last; ++i) {
      const double angle = i * step_deg;
      const brdf::Geometry<double> g{theta, radians(std::abs(angle)),
                                     angle < 0.0 ? optics::pi : 0.0};
      slice.in_plane.deg.push_back(angle);
      slice.in_plane.brdf_per_sr[0].push_back(scale * plastic.brdf(g));
      if (i < 0) continue;
      slice.across.deg.push_back(angle);
      slice.across.brdf_per_sr[0].push_back(scale * plastic.brdf(across(theta, radians(angle))));
    }
    incidences.push_back(std::move(slice));
  }
  return brdf::PlanesTable({wavelength_um}, std::move(incidences), "synthetic MCPET");
}

brdf::PlanesTable dense_mcpet() {
  std::vector<double> theta_i_deg;
  for (int i = 0; i <= 35; ++i) theta_i_deg.push_back(2.5 * i);
  return synthetic_mcpet(theta_i_deg, 0.5);
}

double mcpet_specular(double theta_i_deg) {
  const Plastic plastic;
  const double theta = radians(theta_i_deg);
  const double scale = plastic.scale(theta_i_deg);
  const double level = plastic.brdf(across(theta, radians(60.0)));
  constexpr int radii = 16;
  constexpr int turns = 32;
  const double half = radians(2.5);
  const double solid_angle = 2.0 * optics::pi * (1.0 - std::cos(half));
  double sum = 0.0;
  for (int i = 0; i < radii; ++i) {
    const double away = half * std::sqrt((i + 0.5) / radii);
    for (int k = 0; k < turns; ++k) {
      const double turn = 2.0 * optics::pi * (k + 0.5) / turns;
      // About the mirror direction: away in plane by cos, across by sin.
      const double in_plane = theta + away * std::cos(turn);
      const double beta = away * std::sin(turn);
      const brdf::Geometry<double> g = [&] {
        const double x = std::sin(in_plane) * std::cos(beta);
        const double y = std::sin(beta);
        const double z = std::cos(in_plane) * std::cos(beta);
        return brdf::Geometry<double>{theta, std::atan2(std::hypot(x, y), z), std::atan2(y, x)};
      }();
      if (g.theta_r < 0.5 * optics::pi) {
        sum += std::max(0.0, plastic.brdf(g) - level) * std::cos(g.theta_r);
      }
    }
  }
  return scale * sum / (radii * turns) * solid_angle;
}

DiffuseSpecular mcpet_diffuse_specular() {
  const std::vector<double> theta_i_deg(std::begin(mcpet_theta_i_deg), std::end(mcpet_theta_i_deg));
  std::vector<double> specular;
  for (const double theta : theta_i_deg) specular.push_back(mcpet_specular(theta));
  return {mcpet_total, theta_i_deg, specular};
}

}  // namespace umov::chamber
