#include "host/brdf/dhr.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "host/brdf/adaptive_quadrature.hpp"
#include "host/brdf/evaluate.hpp"
#include "host/errors/error.hpp"

namespace umov::brdf {
namespace {

void check_incidence(double theta_i) {
  if (theta_i >= 0.0 && theta_i < 0.5 * optics::pi) return;
  throw Error(fmt::format("incidence at {:g} degrees has no reflectance", optics::degrees(theta_i)),
              "give an angle from 0 up to, not including, 90 degrees");
}

/// Terms whose integral is known: their sum is returned and their parameters are set to 0. `lobes`
/// gets the slope widths of what is left.
double take_exact_terms(const Model& model, std::vector<double>& parameters, double wavelength_um,
                        double theta_i, std::vector<double>& lobes) {
  const double cos_i = std::cos(theta_i);
  double exact = 0.0;
  for (const Component& part : model.components()) {
    double* p = parameters.data() + part.first;
    switch (part.kind) {
      case Kind::lambertian:
        exact += p[0];
        p[0] = 0.0;
        break;
      case Kind::nef:
        exact += optics::pi * p[0] + 2.0 * optics::pi * p[1] / cos_i;
        p[0] = p[1] = 0.0;
        break;
      case Kind::li_torrance:
        // ∫ T(θr) cos θr dω = π T̄.
        exact += p[5] + p[6] * optics::transmittance(p[0], p[1], cos_i) /
                            optics::transmittance(p[0], p[1], 1.0);
        p[5] = p[6] = 0.0;
        if (p[7] > 0.0) lobes.push_back(0.5 * optics::radians(p[8]));
        [[fallthrough]];
      case Kind::he_torrance: {
        const double phase = 4.0 * optics::pi * p[2] / wavelength_um * cos_i;
        const double spread = std::sqrt(std::max(1.0, phase * phase));
        lobes.push_back(spread * wavelength_um /
                        (std::numbers::sqrt2 * 2.0 * optics::pi * p[3] * cos_i));
        break;
      }
      case Kind::microfacet:
      case Kind::ggx:
        lobes.push_back(p[2]);
        break;
      case Kind::phong:
        lobes.push_back(0.5 / std::sqrt(1.0 + p[1]));
        break;
      case Kind::ward:
        lobes.push_back(std::min(p[1], p[2]) / std::numbers::sqrt2);
        break;
    }
  }
  return exact;
}

}  // namespace

Dhr dhr(const Model& model, std::span<const double> parameters, double wavelength_um,
        double theta_i) {
  check_incidence(theta_i);
  model.check(parameters);
  std::vector<double> values(parameters.begin(), parameters.end());
  std::vector<double> lobes;
  const double exact = take_exact_terms(model, values, wavelength_um, theta_i, lobes);
  if (lobes.empty()) return {exact, exact, exact};

  // Exit directions by the slope (tangent t, azimuth ψ) of the facet that mirrors into them: every
  // lobe then sits at t = 0, whatever its width, and cones there (exponential slopes,
  // Maxwell-Beard) are smooth in t.
  const double cos_i = std::cos(theta_i);
  const double sin_i = std::sin(theta_i);
  const auto along = [&](double psi) {
    const double c = std::cos(psi);
    const double s = std::sin(psi);
    // Where the exit direction meets the horizon: cos θi t² + 2 sin θi cos ψ t - cos θi = 0.
    const double b = sin_i * c;
    const double root = std::sqrt(b * b + cos_i * cos_i);
    const double horizon = b > 0.0 ? cos_i / (b + root) : (root - b) / cos_i;
    const auto at = [&](double t) -> Pair {
      const double cos2_h = 1.0 / (1.0 + t * t);
      const double cos_h = std::sqrt(cos2_h);
      const double cos_d = (cos_i - sin_i * t * c) * cos_h;
      const double x = sin_i + 2.0 * cos_d * cos_h * t * c;
      const double y = 2.0 * cos_d * cos_h * t * s;
      const double z = -cos_i + 2.0 * cos_d * cos_h;
      if (!(z > 0.0)) return {0.0, 0.0};
      const Geometry<double> geometry{theta_i, std::atan2(std::hypot(x, y), z), std::atan2(y, x)};
      const optics::Mueller<double> m = evaluate<double>(model, values, wavelength_um, geometry);
      // dω = 4 cos θd cos³θh · t dt dψ.
      const double measure = 4.0 * cos_d * cos2_h * cos_h * t * z;
      return {measure * optics::element(m, 0, 0), measure * optics::element(m, 0, 1)};
    };
    std::vector<double> breaks{0.0, horizon};
    for (const double width : lobes) {
      for (const double multiple : {3.0, 10.0}) {
        if (multiple * width < 0.9 * horizon) breaks.push_back(multiple * width);
      }
    }
    std::sort(breaks.begin(), breaks.end());
    return integrate(at, breaks, 2e-8).value;
  };
  // The lower half plane y < 0 mirrors the upper one: an isotropic surface, or axes along x and y.
  const std::array<double, 3> quarters{0.0, 0.5 * optics::pi, optics::pi};
  const Pair sum = integrate(along, quarters, 2e-7).value;
  const double unpolarized = exact + 2.0 * sum[0];
  const double difference = 2.0 * sum[1];
  return {unpolarized, unpolarized + difference, unpolarized - difference};
}

Dhr mirror_dhr(const Model& model, std::span<const double> parameters, double wavelength_um,
               double theta_i) {
  check_incidence(theta_i);
  model.check(parameters);
  const optics::Mueller<double> m =
      mirror_reflectance<double>(model, parameters, wavelength_um, theta_i);
  const double unpolarized = optics::element(m, 0, 0);
  const double difference = optics::element(m, 0, 1);
  return {unpolarized, unpolarized + difference, unpolarized - difference};
}

}  // namespace umov::brdf
