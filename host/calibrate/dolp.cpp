#include "host/calibrate/dolp.hpp"

#include <array>
#include <cmath>
#include <map>

#include "host/calibrate/linear_combination.hpp"
#include "host/formats/scan_table.hpp"

namespace umov::calibrate {

namespace {

bool is_axis(double axis_deg, double wanted_deg) {
  return !formats::is_open(axis_deg) &&
         std::abs(std::remainder(axis_deg - wanted_deg, 180.0)) < 0.01;
}

/// Used points of one geometry with P incident, by analyser.
struct Geometry {
  std::vector<std::size_t> p, s, open;
};

}  // namespace

DolpCount add_dolp(formats::BrdfTable& table) {
  const auto& points = table.points;
  table.dolp = {};
  std::map<std::array<long long, 4>, Geometry> geometries;
  std::vector<std::array<long long, 4>> order;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (points.used[i] == 0 || !is_axis(points.polarizer_deg[i], 0)) continue;
    const auto rounded = [](double v) { return std::llround(v * 1e4); };
    const std::array<long long, 4> key = {
        rounded(points.theta_i_deg[i]), rounded(points.theta_r_deg[i]),
        rounded(points.phi_r_deg[i]), rounded(points.wavelength_nm[i])};
    const auto [entry, fresh] = geometries.try_emplace(key);
    if (fresh) order.push_back(key);
    if (is_axis(points.analyzer_deg[i], 0)) entry->second.p.push_back(i);
    if (is_axis(points.analyzer_deg[i], 90)) entry->second.s.push_back(i);
    if (formats::is_open(points.analyzer_deg[i])) entry->second.open.push_back(i);
  }

  DolpCount count;
  for (const auto& key : order) {
    const Geometry& geometry = geometries[key];
    if (geometry.p.empty() || geometry.s.empty()) {
      ++count.skipped;
      continue;
    }
    const LinearCombination p = weighted_mean_of(table, geometry.p);
    const LinearCombination s = weighted_mean_of(table, geometry.s);
    LinearCombination total;
    if (geometry.open.empty()) {
      total.add(p, 1.0);
      total.add(s, 1.0);
    } else {
      total = weighted_mean_of(table, geometry.open);
    }
    const double sum = total.value(table);
    if (!(sum > 3.0 * std::sqrt(total.noise_variance(table)))) {
      ++count.skipped;
      continue;
    }
    ++(geometry.open.empty() ? count.summed : count.measured);
    const double dolp = (p.value(table) - s.value(table)) / sum;
    // d DOLP = (dPP - dPS - DOLP dPU)/PU, which is linear in the points.
    LinearCombination change;
    change.add(p, 1.0 / sum);
    change.add(s, -1.0 / sum);
    change.add(total, -dolp / sum);
    const std::size_t any = geometry.p.front();
    table.dolp.theta_i_deg.push_back(points.theta_i_deg[any]);
    table.dolp.theta_r_deg.push_back(points.theta_r_deg[any]);
    table.dolp.phi_r_deg.push_back(points.phi_r_deg[any]);
    table.dolp.wavelength_nm.push_back(points.wavelength_nm[any]);
    table.dolp.dolp.push_back(dolp);
    table.dolp.dolp_u.push_back(
        std::sqrt(change.noise_variance(table) + change.shared_variance(table)));
  }
  return count;
}

}  // namespace umov::calibrate
