#include "host/cli/study/reduced.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "host/formats/scan_table.hpp"
#include "host/invert/prediction.hpp"

namespace umov::study {
namespace {

constexpr double open = std::numeric_limits<double>::quiet_NaN();

bool same(double a, double b) {
  return (std::isnan(a) && std::isnan(b)) || std::abs(a - b) < 1e-6;
}

}  // namespace

Curve state_curve(const formats::BrdfTable& table, double wavelength_nm, double theta_i_deg,
                  double polarizer_deg, double analyzer_deg) {
  struct Sum {
    double value = 0, variance = 0;
    int count = 0;
  };
  std::map<double, Sum> at;
  const auto& p = table.points;
  for (std::size_t i = 0; i < p.size(); ++i) {
    if (p.used[i] == 0 || p.phi_r_deg[i] != 0 || !same(p.wavelength_nm[i], wavelength_nm) ||
        !same(p.theta_i_deg[i], theta_i_deg) || !same(p.polarizer_deg[i], polarizer_deg) ||
        !same(p.analyzer_deg[i], analyzer_deg))
      continue;
    Sum& sum = at[p.theta_r_deg[i]];
    sum.value += p.brdf_per_sr[i];
    sum.variance += p.brdf_u[i] * p.brdf_u[i];
    ++sum.count;
  }
  Curve curve;
  for (const auto& [theta_r_deg, sum] : at) {
    curve.theta_r_deg.push_back(theta_r_deg);
    curve.value.push_back(sum.value / sum.count);
    curve.u.push_back(std::sqrt(sum.variance) / sum.count);
  }
  return curve;
}

Curve unpolarised_curve(const formats::BrdfTable& table, double wavelength_nm, double theta_i_deg) {
  const Curve p = state_curve(table, wavelength_nm, theta_i_deg, 0, open);
  const Curve s = state_curve(table, wavelength_nm, theta_i_deg, 90, open);
  Curve both;
  for (std::size_t i = 0, j = 0; i < p.value.size() && j < s.value.size();) {
    if (same(p.theta_r_deg[i], s.theta_r_deg[j])) {
      both.theta_r_deg.push_back(p.theta_r_deg[i]);
      both.value.push_back(0.5 * (p.value[i] + s.value[j]));
      both.u.push_back(0.5 * std::hypot(p.u[i], s.u[j]));
      ++i, ++j;
    } else if (p.theta_r_deg[i] < s.theta_r_deg[j]) {
      ++i;
    } else {
      ++j;
    }
  }
  return both;
}

Curve dolp_curve(const formats::BrdfTable& table, double wavelength_nm, double theta_i_deg) {
  const auto& d = table.dolp;
  std::map<double, std::pair<double, double>> at;
  for (std::size_t i = 0; i < d.dolp.size(); ++i)
    if (d.phi_r_deg[i] == 0 && same(d.wavelength_nm[i], wavelength_nm) &&
        same(d.theta_i_deg[i], theta_i_deg))
      at[d.theta_r_deg[i]] = {d.dolp[i], d.dolp_u[i]};
  Curve curve;
  for (const auto& [theta_r_deg, dolp] : at) {
    curve.theta_r_deg.push_back(theta_r_deg);
    curve.value.push_back(dolp.first);
    curve.u.push_back(dolp.second);
  }
  return curve;
}

std::optional<Reflectance> normal_dhr(const formats::BrdfTable& table, double wavelength_nm) {
  const auto& d = table.dhr;
  for (std::size_t i = 0; i < d.dhr.size(); ++i)
    if (same(d.wavelength_nm[i], wavelength_nm) && std::abs(d.theta_i_deg[i]) < 1)
      return Reflectance{d.dhr[i], d.dhr_u[i]};
  return std::nullopt;
}

std::vector<double> model_brdf(const formats::FitResult& fit, double wavelength_nm,
                               double theta_i_deg, const std::vector<double>& theta_r_deg,
                               const std::vector<double>& phi_r_deg) {
  formats::BrdfTable table;
  auto& p = table.points;
  const std::size_t n = theta_r_deg.size();
  p.theta_i_deg.assign(n, theta_i_deg);
  p.theta_r_deg = theta_r_deg;
  p.phi_r_deg = phi_r_deg;
  p.wavelength_nm.assign(n, wavelength_nm);
  p.polarizer_deg.assign(n, open);
  p.analyzer_deg.assign(n, open);
  p.brdf_per_sr.assign(n, 0.0);
  p.brdf_u.assign(n, 1.0);
  p.used.assign(n, 1);
  return invert::predict(fit, table).brdf_per_sr;
}

HemisphereError hemisphere_error(const formats::FitResult& fit, const emulator::SampleTruth& truth,
                                 double wavelength_nm, double theta_i_deg, double share) {
  std::vector<double> theta_r_deg, phi_r_deg;
  for (int theta = 0; theta <= 88; ++theta)
    for (int phi = 0; phi <= 180; phi += 3) {
      theta_r_deg.push_back(theta);
      phi_r_deg.push_back(phi);
    }
  for (double theta = theta_i_deg - 10; theta <= std::min(88.0, theta_i_deg + 10); theta += 0.25)
    for (int phi = 0; phi <= 20; ++phi) {
      if (theta < 0) continue;
      theta_r_deg.push_back(theta);
      phi_r_deg.push_back(phi);
    }
  const auto model = model_brdf(fit, wavelength_nm, theta_i_deg, theta_r_deg, phi_r_deg);
  std::vector<double> exact(theta_r_deg.size());
  for (std::size_t i = 0; i < exact.size(); ++i)
    exact[i] = truth.brdf(theta_i_deg, theta_r_deg[i], phi_r_deg[i], wavelength_nm, open, open);
  const double peak = *std::max_element(exact.begin(), exact.end());
  std::vector<double> sizes;
  std::size_t worst = 0;
  double largest = -1;
  for (std::size_t i = 0; i < exact.size(); ++i) {
    if (!(exact[i] > share * peak)) continue;
    sizes.push_back(std::abs(model[i] / exact[i] - 1));
    if (sizes.back() > largest) {
      largest = sizes.back();
      worst = i;
    }
  }
  HemisphereError part;
  part.all = std::move(sizes);
  HemisphereError error = together({part});
  error.max_theta_r_deg = theta_r_deg[worst];
  error.max_phi_r_deg = phi_r_deg[worst];
  error.wavelength_nm = wavelength_nm;
  error.theta_i_deg = theta_i_deg;
  return error;
}

HemisphereError together(const std::vector<HemisphereError>& parts) {
  HemisphereError result;
  for (const auto& part : parts)
    result.all.insert(result.all.end(), part.all.begin(), part.all.end());
  result.directions = result.all.size();
  if (result.all.empty()) return result;
  std::sort(result.all.begin(), result.all.end());
  const auto quantile = [&](double q) {
    return result.all[static_cast<std::size_t>(q * static_cast<double>(result.all.size() - 1))];
  };
  result.median = quantile(0.5);
  result.p90 = quantile(0.9);
  result.max = result.all.back();
  return result;
}

}  // namespace umov::study
