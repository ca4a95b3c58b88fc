#include "host/cli/study/bench_doubts.hpp"

#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "host/calibrate/declared_doubts.hpp"

namespace umov::study {

formats::BrdfTable with_bench_doubts(formats::BrdfTable table, const BenchDoubts& doubts) {
  auto& p = table.points;
  std::map<std::string, std::vector<double>> factors;
  const auto factor = [&](const std::string& name) -> std::vector<double>& {
    auto& values = factors[name];
    values.resize(p.size(), 0.0);
    return values;
  };
  const auto slopes = calibrate::angle_slopes(p);
  for (std::size_t i = 0; i < p.size(); ++i) {
    const double share = doubts.source * p.brdf_per_sr[i];
    factor(fmt::format("source {:g} nm", p.wavelength_nm[i]))[i] = share;
    factor(fmt::format("source {:g} nm, θi {:g}°", p.wavelength_nm[i],
                       std::round(p.theta_i_deg[i])))[i] = share;
    // Two drives, each with the same doubt.
    const double shift = std::sqrt(2.0) * doubts.position_deg * slopes.detector[i];
    p.brdf_u[i] = std::hypot(p.brdf_u[i], shift);
  }
  for (auto& [name, values] : factors) table.factors.push_back({name, std::move(values)});
  return table;
}

}  // namespace umov::study
