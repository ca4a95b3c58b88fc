#include "host/calibrate/linearity.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include <fmt/format.h>
#include <Eigen/Dense>

namespace umov::calibrate {

namespace {

/// Below this the logarithm of a signal is biased by its noise.
constexpr double least_signal_to_noise = 20.0;
/// A monitor that changes by more than this factor tells of another filter, not of noise.
constexpr double filter_step = 1.3;
constexpr int iterations = 6;

long long rounded(double value) {
  return std::isnan(value) ? -999999999LL : std::llround(value * 1e4);
}

/// One record in a comparison: ln(signal/monitor) of its geometry.
struct Entry {
  double log_ratio, variance;
  double recorded_v;  ///< size of the signal, dark subtracted
  std::size_t range, run;
};

/// Everything of one geometry, states and wavelength in one scan.
using Group = std::vector<Entry>;

struct Material {
  std::vector<double> gains;
  std::vector<Group> groups;
  std::size_t runs = 0, records = 0;
};

bool worth_comparing(const Group& group) {
  return std::any_of(group.begin(), group.end(), [&](const Entry& e) {
    return e.range != group.front().range || e.run != group.front().run;
  });
}

void add_scan(const RangeInput& input, Material& material) {
  const formats::ScanTable& scan = *input.scan;
  using Key = std::array<long long, 6>;
  std::map<Key, Group> groups;
  const auto run = runs_of(scan, *input.set_up);
  for (std::size_t i = 0; i < scan.size(); ++i) {
    if (input.set_up->row[i] != RowUse::plain || scan.saturated[i] != 0) continue;
    if (!(scan.monitor_v[i] > 0)) continue;
    const double gain = scan.gain[i];
    const DarkLevel dark = input.dark->at(gain);
    const double x = scan.x_v[i] - dark.x_v, y = scan.y_v[i] - dark.y_v;
    // What goes with the signal is found from the residuals.
    const double v2 =
        input.noise->variance_floor(scan.wavelength_nm[i], gain, x) + dark.x_u * dark.x_u;
    if (!(x > least_signal_to_noise * std::sqrt(v2))) continue;
    const Key key = {rounded(scan.theta_i_deg[i]),   rounded(scan.theta_r_deg[i]),
                     rounded(scan.phi_r_deg[i]),     rounded(scan.wavelength_nm[i]),
                     rounded(scan.polarizer_deg[i]), rounded(scan.analyzer_deg[i])};
    const auto place = std::find(material.gains.begin(), material.gains.end(), gain);
    groups[key].push_back({std::log(x / scan.monitor_v[i]), v2 / (x * x), std::hypot(x, y),
                           static_cast<std::size_t>(place - material.gains.begin()),
                           material.runs + run[i]});
  }
  if (!run.empty()) material.runs += *std::max_element(run.begin(), run.end()) + 1;
  for (auto& [key, group] : groups)
    if (worth_comparing(group)) {
      material.records += group.size();
      material.groups.push_back(std::move(group));
    }
}

/// Runs that occur in comparisons, numbered without gaps.
void drop_unused_runs(Material& material) {
  std::map<std::size_t, std::size_t> place;
  for (Group& group : material.groups)
    for (Entry& e : group) e.run = place.emplace(e.run, place.size()).first->second;
  material.runs = place.size();
}

/// Normal equations of [range errors, κ, runs] with the level of each group eliminated.
class Fit {
 public:
  Fit(const Material& material, double slow2)
      : material_(material),
        slow2_(slow2),
        ranges_(static_cast<Eigen::Index>(material.gains.size())),
        size_(ranges_ + 1 + static_cast<Eigen::Index>(material.runs)) {}

  Eigen::Index kappa() const { return ranges_; }

  /// Gauss–Newton from zero; `prior` holds the weights 1/u² of the parameters about zero.
  void solve(const Eigen::VectorXd& prior) {
    parameters = Eigen::VectorXd::Zero(size_);
    for (int k = 0; k < iterations; ++k) {
      linearise();
      const Eigen::MatrixXd full = normal + Eigen::MatrixXd(prior.asDiagonal());
      const Eigen::LDLT<Eigen::MatrixXd> solver(full);
      const Eigen::VectorXd step = solver.solve(right - prior.cwiseProduct(parameters));
      parameters += step;
      if (step.cwiseAbs().maxCoeff() < 1e-12) break;
    }
    linearise();
    const Eigen::MatrixXd full = normal + Eigen::MatrixXd(prior.asDiagonal());
    covariance = full.ldlt().solve(Eigen::MatrixXd::Identity(size_, size_));
  }

  /// Parameters that data and prior fix together, in units of full ones: the trace of the data's
  /// share.
  double parameters_used() const { return (covariance * normal).trace(); }

  Eigen::VectorXd parameters;
  Eigen::MatrixXd normal, covariance;
  Eigen::VectorXd right;
  double chi2 = 0;

 private:
  void linearise() {
    normal = Eigen::MatrixXd::Zero(size_, size_);
    right = Eigen::VectorXd::Zero(size_);
    chi2 = 0;
    Eigen::VectorXd lever_sum = Eigen::VectorXd::Zero(size_);
    for (const Group& group : material_.groups) {
      double weight_sum = 0, mean = 0;
      std::set<Eigen::Index> touched;
      const auto levers = [&](const Entry& e) {
        const auto range = static_cast<Eigen::Index>(e.range);
        const double recorded = e.recorded_v / (1.0 + parameters(range));
        const double slope = 1.0 / (1.0 - parameters(kappa()) * recorded);
        return std::array<std::pair<Eigen::Index, double>, 3>{
            {{range, 1.0 / (1.0 + parameters(range))},
             {kappa(), -recorded * slope},
             {kappa() + 1 + static_cast<Eigen::Index>(e.run), 1.0}}};
      };
      for (const Entry& e : group) {
        const double w = 1.0 / (e.variance + slow2_);
        weight_sum += w;
        mean += w * residual(e);
        for (const auto& [at, lever] : levers(e)) {
          lever_sum(at) += w * lever;
          touched.insert(at);
        }
      }
      mean /= weight_sum;
      for (const Entry& e : group) {
        const double w = 1.0 / (e.variance + slow2_), r = residual(e) - mean;
        chi2 += w * r * r;
        const auto own = levers(e);
        for (const auto& [a, lever_a] : own) {
          right(a) += w * lever_a * r;
          for (const auto& [b, lever_b] : own) normal(a, b) += w * lever_a * lever_b;
        }
      }
      for (Eigen::Index a : touched)
        for (Eigen::Index b : touched) normal(a, b) -= lever_sum(a) * lever_sum(b) / weight_sum;
      for (Eigen::Index a : touched) lever_sum(a) = 0;
    }
  }

  /// ln(signal/monitor) with everything known taken out.
  double residual(const Entry& e) const {
    const double error = parameters(static_cast<Eigen::Index>(e.range));
    const double recorded = e.recorded_v / (1.0 + error);
    return e.log_ratio - std::log1p(error) - std::log1p(-parameters(kappa()) * recorded) -
           parameters(kappa() + 1 + static_cast<Eigen::Index>(e.run));
  }

  const Material& material_;
  double slow2_;
  Eigen::Index ranges_, size_;
};

constexpr double exact = 1e18;  ///< weight of what is known to be zero

double weight_of(double u) {
  return u > 0 ? std::min(1.0 / (u * u), exact) : exact;
}

/// Prior weights: ranges as in find_range_errors, the lowest one exact by convention.
Eigen::VectorXd priors(const Material& material, const std::vector<bool>& seen, double kappa_u,
                       const LinearityOptions& options) {
  const auto ranges = static_cast<Eigen::Index>(material.gains.size());
  Eigen::VectorXd prior(ranges + 1 + static_cast<Eigen::Index>(material.runs));
  prior(0) = exact;
  for (Eigen::Index k = 1; k < ranges; ++k)
    prior(k) =
        weight_of((seen[static_cast<std::size_t>(k)] ? 10.0 : 1.0) * options.range_tolerance);
  prior(ranges) = weight_of(kappa_u);
  prior.tail(static_cast<Eigen::Index>(material.runs)).setConstant(weight_of(options.drift));
  return prior;
}

/// Ranges whose records are compared with those of another range.
std::vector<bool> compared_ranges(const Material& material) {
  std::vector<bool> seen(material.gains.size(), false);
  for (const Group& group : material.groups)
    for (const Entry& e : group)
      if (e.range != group.front().range) seen[e.range] = seen[group.front().range] = true;
  return seen;
}

/// Slow scatter that makes chi2 what its degrees of freedom say, by bisection in its logarithm.
double find_slow_noise(const Material& material, const Eigen::VectorXd& prior) {
  const auto excess = [&](double slow2) {
    Fit fit(material, slow2);
    fit.solve(prior);
    const double dof =
        static_cast<double>(material.records - material.groups.size()) - fit.parameters_used();
    return dof > 0 ? fit.chi2 / dof - 1.0 : -1.0;
  };
  if (excess(0.0) <= 0) return 0;
  double low = 1e-12, high = 1e-2;
  if (excess(low) <= 0) return 0;
  for (int k = 0; k < 24; ++k) {
    const double middle = std::sqrt(low * high);
    (excess(middle) > 0 ? low : high) = middle;
  }
  return std::sqrt(low * high);
}

void describe(const Material& material, const Fit& fit, Linearity& result) {
  Nonlinearity& law = result.nonlinearity;
  if (material.groups.empty()) {
    result.notes.push_back(fmt::format(
        "linearity: no geometry was measured at several powers or ranges; kappa = 0 +- {:.2g} /V "
        "is assumed (a block `nd` measures it)",
        law.kappa_u_per_v));
    return;
  }
  if (!law.measured)
    result.notes.push_back(fmt::format(
        "linearity: the comparisons (signals up to {:.3g} V) say less of kappa than the tolerance "
        "does; kappa = {:.2g} +- {:.2g} /V rests on it",
        law.strongest_v, law.kappa_per_v, law.kappa_u_per_v));
  for (Eigen::Index k = 1; k < fit.kappa(); ++k) {
    const double u = std::sqrt(fit.covariance(k, k) * fit.covariance(fit.kappa(), fit.kappa()));
    const double correlation = fit.covariance(k, fit.kappa()) / u;
    if (law.measured && std::abs(correlation) > 0.95)
      result.notes.push_back(fmt::format(
          "linearity: kappa and the error of amplifier range {:g} can hardly be told apart "
          "(correlation {:+.2f}): measure the same power in both ranges, or power steps within one",
          material.gains[static_cast<std::size_t>(k)], correlation));
  }
}

}  // namespace

std::vector<std::size_t> runs_of(const formats::ScanTable& scan, const ScanRows& set_up) {
  std::vector<std::size_t> run(scan.size(), 0);
  for (std::size_t i = 1; i < scan.size(); ++i) {
    const std::size_t j = i - 1;
    const double a = scan.monitor_v[j], b = scan.monitor_v[i];
    const bool same_polarizer = rounded(scan.polarizer_deg[i]) == rounded(scan.polarizer_deg[j]);
    const bool stepped = same_polarizer && a > 0 && b > 0 && std::max(a / b, b / a) > filter_step;
    const bool cut = stepped || set_up.block[i] != set_up.block[j] ||
                     std::abs(scan.wavelength_nm[i] - scan.wavelength_nm[j]) >= 0.5 ||
                     scan.theta_i_deg[i] != scan.theta_i_deg[j];
    run[i] = run[j] + (cut ? 1 : 0);
  }
  return run;
}

Eigen::MatrixXd electronics_shifts(const RangeErrors& ranges, const Nonlinearity& nonlinearity) {
  const Eigen::Index n = ranges.covariance.rows();
  RangeErrors joint;
  joint.covariance = Eigen::MatrixXd::Zero(n + 1, n + 1);
  joint.covariance.topLeftCorner(n, n) = ranges.covariance;
  joint.covariance(n, n) = nonlinearity.kappa_u_per_v * nonlinearity.kappa_u_per_v;
  if (nonlinearity.with_ranges.size() == n) {
    joint.covariance.topRightCorner(n, 1) = nonlinearity.with_ranges;
    joint.covariance.bottomLeftCorner(1, n) = nonlinearity.with_ranges.transpose();
  }
  return joint.shifts();
}

Linearity find_linearity(std::span<const RangeInput> inputs, const LinearityOptions& options) {
  Material material;
  std::set<double> gains;
  for (const RangeInput& input : inputs)
    gains.insert(input.scan->gain.begin(), input.scan->gain.end());
  material.gains.assign(gains.begin(), gains.end());
  for (const RangeInput& input : inputs) add_scan(input, material);
  drop_unused_runs(material);

  Linearity result;
  result.ranges.tolerance = options.range_tolerance;
  Nonlinearity& law = result.nonlinearity;
  law.kappa_u_per_v = options.kappa_tolerance_per_v;
  law.with_ranges = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(material.gains.size()));
  if (material.gains.empty()) return result;

  const std::vector<bool> seen = compared_ranges(material);
  // Without the tolerance of kappa first: do the scans contradict it?
  const double no_prior = 1e3 * options.kappa_tolerance_per_v;
  const double slow2 = find_slow_noise(material, priors(material, seen, no_prior, options));
  Fit fit(material, slow2);
  fit.solve(priors(material, seen, no_prior, options));
  const auto kappa_u = [&] { return std::sqrt(fit.covariance(fit.kappa(), fit.kappa())); };
  const double alone = fit.parameters(fit.kappa()), alone_u = kappa_u();
  fit.solve(priors(material, seen, options.kappa_tolerance_per_v, options));
  law.measured = alone_u < options.kappa_tolerance_per_v;
  if (std::abs(alone) > 3.0 * std::hypot(alone_u, options.kappa_tolerance_per_v))
    result.notes.push_back(fmt::format(
        "linearity: the comparisons alone say kappa = {:.2g} +- {:.2g} /V, far beyond the "
        "tolerance "
        "of {:.2g}, which pulls the result towards zero: look at the detector, or raise "
        "tolerance.nonlinearity_per_v",
        alone, alone_u, options.kappa_tolerance_per_v));
  law.kappa_per_v = fit.parameters(fit.kappa());
  law.kappa_u_per_v = kappa_u();
  law.records = material.records;
  law.dof = std::max(
      0.0, static_cast<double>(material.records - material.groups.size()) - fit.parameters_used());
  for (const Group& group : material.groups)
    for (const Entry& e : group) law.strongest_v = std::max(law.strongest_v, e.recorded_v);

  const Eigen::Index n = fit.kappa();
  result.ranges.covariance = fit.covariance.topLeftCorner(n, n);
  result.ranges.covariance.row(0).setZero();
  result.ranges.covariance.col(0).setZero();
  law.with_ranges = fit.covariance.col(n).head(n);
  law.with_ranges(0) = 0;
  for (Eigen::Index k = 0; k < n; ++k) {
    RangeError range;
    range.gain = material.gains[static_cast<std::size_t>(k)];
    range.error = k == 0 ? 0.0 : fit.parameters(k);
    range.u = k == 0 ? 0.0 : std::sqrt(result.ranges.covariance(k, k));
    range.measured = k > 0 && seen[static_cast<std::size_t>(k)];
    result.ranges.ranges.push_back(range);
  }
  result.slow_noise = std::sqrt(slow2);
  result.chi2 = fit.chi2;
  describe(material, fit, result);
  return result;
}

}  // namespace umov::calibrate
