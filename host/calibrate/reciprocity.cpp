#include "host/calibrate/reciprocity.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include <Eigen/Dense>

#include "host/calibrate/reference_standard.hpp"
#include "host/formats/scan_table.hpp"

namespace umov::calibrate {

namespace {

/// Direction pair, states and wavelength on a grid of the tolerance.
using Key = std::tuple<long long, long long, long long, long long, long long, long long>;

/// Incidence and exit with the exit's sign (forward half plane positive) taken into the azimuth.
struct Directions {
  double incidence, exit, azimuth;
};

Directions directions_of(const formats::BrdfTable::Points& points, std::size_t i) {
  double exit = points.theta_r_deg[i], azimuth = points.phi_r_deg[i];
  if (exit < 0) {
    exit = -exit;
    azimuth += 180.0;
  }
  azimuth = std::abs(std::remainder(azimuth, 360.0));  // isotropic samples have a mirror plane
  if (exit == 0 || points.theta_i_deg[i] == 0) azimuth = 0;
  return {points.theta_i_deg[i], exit, azimuth};
}

bool along_s_or_p(double axis_deg) {
  return std::abs(std::remainder(axis_deg, 90.0)) < 0.01;
}

long long axis_key(double axis_deg, bool turned) {
  if (formats::is_open(axis_deg)) return -1;
  const double signed_axis = turned ? -axis_deg : axis_deg;
  return std::llround((signed_axis - 180.0 * std::floor(signed_axis / 180.0)) * 100.0) % 18000;
}

Key key_of(const Directions& d, double wavelength, double from, double to, bool exchanged,
           double tolerance) {
  const auto cell = [tolerance](double angle) { return std::llround(angle / tolerance); };
  return exchanged ? Key{cell(d.exit),       cell(d.incidence),
                         cell(d.azimuth),    std::llround(wavelength * 2),
                         axis_key(to, true), axis_key(from, true)}
                   : Key{cell(d.incidence),     cell(d.exit),
                         cell(d.azimuth),       std::llround(wavelength * 2),
                         axis_key(from, false), axis_key(to, false)};
}

Reciprocity evaluate(const formats::BrdfTable& table, const std::vector<ReciprocalPair>& pairs) {
  Reciprocity result;
  const auto n = static_cast<Eigen::Index>(pairs.size());
  const auto factors = static_cast<Eigen::Index>(table.factors.size());
  const auto& p = table.points;
  // Covariance of the deviations: own noise, points that several pairs share, and the factors.
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(n, n);
  Eigen::MatrixXd shifts(n, factors);
  Eigen::VectorXd deviation(n);
  std::map<std::size_t, std::vector<std::pair<Eigen::Index, double>>> levers;
  for (Eigen::Index k = 0; k < n; ++k) {
    const ReciprocalPair& pair = pairs[static_cast<std::size_t>(k)];
    deviation(k) = pair.deviation;
    levers[pair.forth].emplace_back(k, 1.0 / p.brdf_per_sr[pair.forth]);
    levers[pair.back].emplace_back(k, -1.0 / p.brdf_per_sr[pair.back]);
    for (Eigen::Index f = 0; f < factors; ++f) {
      const auto& shift = table.factors[static_cast<std::size_t>(f)].per_point;
      shifts(k, f) = shift[pair.forth] / p.brdf_per_sr[pair.forth] -
                     shift[pair.back] / p.brdf_per_sr[pair.back];
    }
  }
  for (const auto& [point, own] : levers)
    for (const auto& [a, lever_a] : own)
      for (const auto& [b, lever_b] : own)
        covariance(a, b) += lever_a * lever_b * p.brdf_u[point] * p.brdf_u[point];
  covariance += shifts * shifts.transpose();
  result.pairs = pairs.size();
  const double count = static_cast<double>(n);
  result.mean = deviation.mean();
  result.mean_u = std::sqrt(covariance.sum()) / count;
  result.mean_absolute = deviation.cwiseAbs().mean();
  result.rms = std::sqrt(deviation.squaredNorm() / count);
  result.rms_expected = std::sqrt(covariance.trace() / count);
  Eigen::Index worst = 0;
  result.largest = deviation.cwiseAbs().maxCoeff(&worst);
  const std::size_t at = pairs[static_cast<std::size_t>(worst)].forth;
  result.largest_theta_i_deg = p.theta_i_deg[at];
  result.largest_theta_r_deg = p.theta_r_deg[at];
  const Eigen::LDLT<Eigen::MatrixXd> solver(covariance);
  result.chi2 = deviation.dot(solver.solve(deviation));
  return result;
}

}  // namespace

std::vector<ReciprocalPair> reciprocal_pairs(const formats::BrdfTable& table,
                                             const ReciprocityOptions& options) {
  const auto& p = table.points;
  const auto eligible = [&](std::size_t i) {
    if (p.used[i] == 0 || !(p.brdf_per_sr[i] > 0)) return false;
    if (p.theta_i_deg[i] > options.within_deg + options.tolerance_deg ||
        std::abs(p.theta_r_deg[i]) > options.within_deg + options.tolerance_deg)
      return false;
    const bool open_in = formats::is_open(p.polarizer_deg[i]),
               open_out = formats::is_open(p.analyzer_deg[i]);
    if (open_in || open_out) return open_in && open_out;
    // U depends on the side the azimuth turns to, which is folded here.
    return (along_s_or_p(p.polarizer_deg[i]) && along_s_or_p(p.analyzer_deg[i])) ||
           std::abs(std::remainder(p.phi_r_deg[i], 180.0)) < options.tolerance_deg;
  };
  std::map<Key, std::vector<std::size_t>> places;
  for (std::size_t i = 0; i < p.size(); ++i)
    if (eligible(i))
      places[key_of(directions_of(p, i), p.wavelength_nm[i], p.polarizer_deg[i], p.analyzer_deg[i],
                    false, options.tolerance_deg)]
          .push_back(i);
  std::vector<ReciprocalPair> pairs;
  std::map<Key, std::size_t> taken;  // repeats pair off one by one
  for (std::size_t i = 0; i < p.size(); ++i) {
    if (!eligible(i)) continue;
    const Directions d = directions_of(p, i);
    // Each pair once: from the larger incidence.
    if (!(d.incidence > d.exit + options.tolerance_deg)) continue;
    const Key back = key_of(d, p.wavelength_nm[i], p.polarizer_deg[i], p.analyzer_deg[i], true,
                            options.tolerance_deg);
    const auto found = places.find(back);
    if (found == places.end()) continue;
    std::size_t& next = taken[back];
    if (next >= found->second.size()) continue;
    ReciprocalPair pair;
    pair.forth = i;
    pair.back = found->second[next++];
    pair.deviation = std::log(p.brdf_per_sr[pair.forth] / p.brdf_per_sr[pair.back]);
    double variance = std::pow(p.brdf_u[pair.forth] / p.brdf_per_sr[pair.forth], 2) +
                      std::pow(p.brdf_u[pair.back] / p.brdf_per_sr[pair.back], 2);
    for (const auto& factor : table.factors)
      variance += std::pow(factor.per_point[pair.forth] / p.brdf_per_sr[pair.forth] -
                               factor.per_point[pair.back] / p.brdf_per_sr[pair.back],
                           2);
    pair.deviation_u = std::sqrt(variance);
    pairs.push_back(pair);
  }
  return pairs;
}

std::vector<Reciprocity> check_reciprocity(const formats::BrdfTable& table,
                                           const ReciprocityOptions& options) {
  const auto pairs = reciprocal_pairs(table, options);
  std::vector<Reciprocity> results;
  if (pairs.empty()) return results;
  std::string sample;
  for (const auto& [name, value] : table.keys)
    if (name == "sample") sample = value;
  results.push_back(evaluate(table, pairs));
  std::map<double, std::vector<ReciprocalPair>> by_wavelength;
  for (const ReciprocalPair& pair : pairs)
    by_wavelength[table.points.wavelength_nm[pair.forth]].push_back(pair);
  for (const auto& [wavelength, own] : by_wavelength) {
    results.push_back(evaluate(table, own));
    results.back().wavelength_nm = wavelength;
  }
  for (Reciprocity& result : results) result.sample = sample;
  return results;
}

std::optional<StandardShape> find_standard_shape(const formats::BrdfTable& table, double prior_u) {
  constexpr double another_curve = 0.1;  // of |a|: a one-parameter curve is not the true one
  ReciprocityOptions wide;
  wide.within_deg = 80;
  const auto pairs = reciprocal_pairs(table, wide);
  if (pairs.size() < 10 || !(prior_u > 0)) return std::nullopt;
  const auto& p = table.points;
  StandardShape result;
  result.pairs = pairs.size();
  double widening = 1, information = 0;
  for (int round = 0; round < 8; ++round) {
    const double a = result.amplitude;
    double normal = 1.0 / (prior_u * prior_u), right = -a / (prior_u * prior_u), chi2 = 0;
    information = 0;
    for (const ReciprocalPair& pair : pairs) {
      const double i = ReferenceStandard::shape(p.theta_i_deg[pair.forth]),
                   r = ReferenceStandard::shape(p.theta_r_deg[pair.forth]);
      const double variance = std::pow(p.brdf_u[pair.forth] / p.brdf_per_sr[pair.forth], 2) +
                              std::pow(p.brdf_u[pair.back] / p.brdf_per_sr[pair.back], 2);
      const double residual = pair.deviation - std::log1p(a * i) + std::log1p(a * r);
      const double lever = i / (1 + a * i) - r / (1 + a * r);
      chi2 += residual * residual / variance;
      normal += lever * lever / (variance * widening);
      right += lever * residual / (variance * widening);
    }
    information = normal;
    widening = std::max(1.0, chi2 / static_cast<double>(pairs.size() - 1));
    result.amplitude += right / normal;
  }
  result.u = std::hypot(std::sqrt(1.0 / information), another_curve * result.amplitude);
  return result;
}

}  // namespace umov::calibrate
