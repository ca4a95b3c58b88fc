#include "host/calibrate/gain_range.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include <Eigen/Dense>

namespace umov::calibrate {

namespace {

struct Level {
  double sum = 0, weight = 0;
  void add(double value, double variance) {
    sum += value / variance;
    weight += 1.0 / variance;
  }
  double mean() const { return sum / weight; }
};

long long rounded(double value) {
  return std::isnan(value) ? -999999999LL : std::llround(value * 1e4);
}

/// ln(signal in range b / signal in range a) of one geometry.
struct Comparison {
  double a, b, log_ratio, variance;
};

std::vector<Comparison> compare(const RangeInput& input) {
  const formats::ScanTable& scan = *input.scan;
  using Key = std::array<long long, 6>;
  std::map<Key, std::map<double, Level>> groups;
  for (std::size_t i = 0; i < scan.size(); ++i) {
    if (input.set_up->row[i] != RowUse::plain || scan.saturated[i] != 0) continue;
    if (!(scan.monitor_v[i] > 0)) continue;
    const double gain = scan.gain[i];
    const DarkLevel dark = input.dark->at(gain);
    const double x = scan.x_v[i] - dark.x_v;
    const double v2 =
        input.noise->variance_normalised(scan.wavelength_nm[i], gain, x) + dark.x_u * dark.x_u;
    if (!(x > 20.0 * std::sqrt(v2))) continue;
    const Key key = {rounded(scan.theta_i_deg[i]),   rounded(scan.theta_r_deg[i]),
                     rounded(scan.phi_r_deg[i]),     rounded(scan.wavelength_nm[i]),
                     rounded(scan.polarizer_deg[i]), rounded(scan.analyzer_deg[i])};
    const double m = scan.monitor_v[i];
    groups[key][gain].add(x / m, v2 / (m * m));
  }
  std::vector<Comparison> result;
  for (const auto& [key, levels] : groups) {
    for (auto a = levels.begin(); a != levels.end(); ++a) {
      const auto b = std::next(a);
      if (b == levels.end()) break;
      const double ma = a->second.mean(), mb = b->second.mean();
      result.push_back({a->first, b->first, std::log(mb / ma),
                        1.0 / (a->second.weight * ma * ma) + 1.0 / (b->second.weight * mb * mb)});
    }
  }
  return result;
}

}  // namespace

RangeError RangeErrors::at(double gain) const {
  for (const RangeError& range : ranges)
    if (range.gain == gain) return range;
  RangeError nominal;
  nominal.gain = gain;
  nominal.u = tolerance;
  return nominal;
}

Eigen::Index RangeErrors::number(double gain) const {
  for (std::size_t k = 0; k < ranges.size(); ++k)
    if (ranges[k].gain == gain) return static_cast<Eigen::Index>(k);
  return -1;
}

Eigen::MatrixXd RangeErrors::shifts() const {
  const Eigen::Index n = covariance.rows();
  Eigen::MatrixXd lower = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const double pivot = covariance(k, k) - lower.row(k).squaredNorm();
    if (!(pivot > 1e-12 * covariance(k, k))) continue;
    lower(k, k) = std::sqrt(pivot);
    for (Eigen::Index r = k + 1; r < n; ++r)
      lower(r, k) = (covariance(r, k) - lower.row(r).dot(lower.row(k))) / lower(k, k);
  }
  return lower;
}

RangeErrors find_range_errors(std::span<const RangeInput> inputs, double tolerance) {
  std::set<double> gains;
  std::vector<Comparison> comparisons;
  for (const RangeInput& input : inputs) {
    gains.insert(input.scan->gain.begin(), input.scan->gain.end());
    const auto found = compare(input);
    comparisons.insert(comparisons.end(), found.begin(), found.end());
  }
  RangeErrors result;
  result.tolerance = tolerance;
  if (gains.empty()) return result;
  const std::vector<double> gain(gains.begin(), gains.end());
  const auto n = static_cast<Eigen::Index>(gain.size());
  // Least squares with the tolerance as a prior; the lowest range is exact by convention.
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(n);
  const auto number = [&gain](double g) {
    return static_cast<Eigen::Index>(std::find(gain.begin(), gain.end(), g) - gain.begin());
  };
  for (const Comparison& c : comparisons) {
    const Eigen::Index a = number(c.a), b = number(c.b);
    const double w = 1.0 / c.variance;
    normal(a, a) += w;
    normal(b, b) += w;
    normal(a, b) -= w;
    normal(b, a) -= w;
    right(b) += w * c.log_ratio;
    right(a) -= w * c.log_ratio;
  }
  std::vector<bool> seen(gain.size());
  for (Eigen::Index k = 0; k < n; ++k) seen[static_cast<std::size_t>(k)] = normal(k, k) > 0;
  constexpr double exact_weight = 1e18;  // of an error that is known to be zero
  normal(0, 0) += exact_weight;
  for (Eigen::Index k = 1; k < n; ++k) {
    // Where data speak, the prior only ties ranges that have no link down to the lowest.
    const double width = seen[static_cast<std::size_t>(k)] ? 10.0 * tolerance : tolerance;
    normal(k, k) += std::min(1.0 / (width * width), exact_weight);
  }
  const Eigen::LDLT<Eigen::MatrixXd> solver(normal);
  const Eigen::VectorXd error = solver.solve(right);
  result.covariance = solver.solve(Eigen::MatrixXd::Identity(n, n));
  result.covariance.row(0).setZero();
  result.covariance.col(0).setZero();
  for (Eigen::Index k = 0; k < n; ++k) {
    RangeError range;
    range.gain = gain[static_cast<std::size_t>(k)];
    range.error = k == 0 ? 0.0 : std::expm1(error(k));
    range.u = k == 0 ? 0.0 : std::sqrt(result.covariance(k, k));
    range.measured = k > 0 && seen[static_cast<std::size_t>(k)];
    result.ranges.push_back(range);
  }
  return result;
}

}  // namespace umov::calibrate
