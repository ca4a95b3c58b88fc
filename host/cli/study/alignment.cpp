#include "host/cli/study/alignment.hpp"

#include <cmath>
#include <string_view>

namespace umov::study {
namespace {

constexpr double radians = 3.14159265358979323846 / 180;

double found(const formats::FitResult& fit, std::string_view name, double u_deg) {
  for (const auto& factor : fit.factors)
    if (factor.name == name) return factor.value * u_deg;
  return 0;
}

}  // namespace

Alignment alignment_found(const formats::FitResult& fit, double theta_i_u_deg,
                          double theta_r_u_deg) {
  return {found(fit, "incidence zero", theta_i_u_deg), found(fit, "detector zero", theta_r_u_deg)};
}

formats::BrdfTable aligned(formats::BrdfTable table, const Alignment& alignment) {
  auto& p = table.points;
  for (std::size_t i = 0; i < p.size(); ++i) {
    if (p.phi_r_deg[i] != 0) continue;
    const double commanded = p.theta_r_deg[i];
    const double scale =
        std::cos(radians * commanded) / std::cos(radians * (commanded + alignment.theta_r_deg));
    p.theta_i_deg[i] += alignment.theta_i_deg;
    p.theta_r_deg[i] += alignment.theta_r_deg;
    p.brdf_per_sr[i] *= scale;
    p.brdf_u[i] *= scale;
    for (auto& factor : table.factors) factor.per_point[i] *= scale;
  }
  return table;
}

}  // namespace umov::study
