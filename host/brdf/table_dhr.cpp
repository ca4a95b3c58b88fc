#include "host/brdf/table_dhr.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "host/brdf/gauss_legendre.hpp"
#include "host/brdf/sampling_directions.hpp"

namespace umov::brdf {
namespace {

Integral by_cells(const Table& table, double wavelength_um, double theta_i,
                  const ExitBreaks& breaks) {
  const auto& nodes = GaussLegendre<6>::instance();
  Integral sum;
  for (std::size_t r = 0; r + 1 < breaks.theta_r.size(); ++r) {
    const double width = breaks.theta_r[r + 1] - breaks.theta_r[r];
    for (std::size_t k = 0; k < nodes.node.size(); ++k) {
      const double theta = breaks.theta_r[r] + width * nodes.node[k];
      const double weight = 0.5 * std::sin(2.0 * theta) * width * nodes.weight[k];
      for (std::size_t p = 0; p + 1 < breaks.phi_r.size(); ++p) {
        // Linear in φ within a cell: its middle says all.
        const double middle = 0.5 * (breaks.phi_r[p] + breaks.phi_r[p + 1]);
        const double measure = weight * (breaks.phi_r[p + 1] - breaks.phi_r[p]);
        const optics::Mueller<double> m = table.at(wavelength_um, {theta_i, theta, middle});
        sum.value[0] += measure * optics::element(m, 0, 0);
        sum.value[1] += measure * optics::element(m, 0, 1);
      }
    }
  }
  sum.error = 1e-9 * std::max(1.0, std::abs(sum.value[0]));
  return sum;
}

/// Midpoint rule over the slopes (tangent t, azimuth ψ) of the facet that mirrors into the exit
/// direction, as dhr() has them, with t = horizon · u².
Pair by_facets(const Table& table, double wavelength_um, double theta_i, int divisions) {
  const Incidence in(theta_i);
  Pair sum{0.0, 0.0};
  for (int j = 0; j < divisions; ++j) {
    const double psi = optics::pi * (2.0 * (j + 0.5) / divisions - 1.0);
    const double c = std::cos(psi), s = std::sin(psi);
    const double horizon = horizon_slope(in, c);
    for (int k = 0; k < divisions; ++k) {
      const double u = (k + 0.5) / divisions;
      const double t = horizon * u * u;
      const optics::Vec3<double> to = mirrored(in, t * c, t * s);
      if (!(to.z > 0.0)) continue;
      const optics::Mueller<double> m = table.at(wavelength_um, geometry_of(theta_i, to));
      const double measure = Exit(in, to).sr_per_slope_area() * t * to.z * 2.0 * horizon * u;
      sum[0] += measure * optics::element(m, 0, 0);
      sum[1] += measure * optics::element(m, 0, 1);
    }
  }
  const double cell = 2.0 * optics::pi / divisions / divisions;
  return {sum[0] * cell, sum[1] * cell};
}

}  // namespace

Integral integrate_table(const Table& table, double wavelength_um, double theta_i, double wanted,
                         int most_divisions) {
  const ExitBreaks breaks = table.exit_breaks();
  if (!breaks.theta_r.empty()) return by_cells(table, wavelength_um, theta_i, breaks);
  Integral result;
  result.value = by_facets(table, wavelength_um, theta_i, 64);
  for (int divisions = 128; divisions <= most_divisions; divisions *= 2) {
    const Pair finer = by_facets(table, wavelength_um, theta_i, divisions);
    result.error =
        std::max(std::abs(finer[0] - result.value[0]), std::abs(finer[1] - result.value[1]));
    result.value = finer;
    if (result.error < wanted * std::max(1.0, std::abs(finer[0]))) break;
  }
  return result;
}

}  // namespace umov::brdf
