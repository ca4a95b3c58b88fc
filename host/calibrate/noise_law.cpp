// Fit of the variance law to scaled chi-square variates: iteratively reweighted least squares,
// which is Fisher scoring of the gamma likelihood with the identity link, over all subsets of the
// terms.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <Eigen/Dense>

#include "host/calibrate/noise.hpp"
#include "host/formats/order_statistics.hpp"

namespace umov::calibrate {

namespace {

constexpr int terms = 4;
/// Records whose cube-rooted scatter lies further out than this (standard deviations, upwards only)
/// carry a spike, not noise. Below one in 10⁵ of good ones.
constexpr double outlier_z = 4.5;

struct Fit {
  std::array<double, terms> coefficient{};
  std::vector<double> variance;
  double deviance = std::numeric_limits<double>::infinity();  ///< Σ (s²/V + ln V)
};

/// Mean of v2 among rows of similar signal (column 2 of the design): weights to start from. From
/// equal weights the strongest signals rule and the iteration can run into negative floors.
Eigen::VectorXd local_mean(const Eigen::MatrixXd& design, const Eigen::VectorXd& v2) {
  std::vector<Eigen::Index> order(static_cast<std::size_t>(v2.size()));
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<Eigen::Index>(i);
  std::sort(order.begin(), order.end(),
            [&design](Eigen::Index a, Eigen::Index b) { return design(a, 2) < design(b, 2); });
  const std::size_t width = std::max<std::size_t>(6, order.size() / 20);
  Eigen::VectorXd result(v2.size());
  for (std::size_t first = 0; first < order.size(); first += width) {
    const std::size_t last = std::min(first + width, order.size());
    double sum = 0;
    for (std::size_t k = first; k < last; ++k) sum += v2(order[k]);
    for (std::size_t k = first; k < last; ++k)
      result(order[k]) = sum / static_cast<double>(last - first);
  }
  return result.cwiseMax(1e-6 * v2.mean());
}

/// Weighted least squares of v2 on the terms of `mask`, weights 1/V², until it stands still.
/// Infinite deviance where a coefficient would be negative: the optimum then lies in a subset.
Fit fit_subset(const Eigen::MatrixXd& design, const Eigen::VectorXd& v2,
               const Eigen::VectorXd& start, int mask) {
  std::vector<int> columns;
  for (int k = 0; k < terms; ++k)
    if (mask & (1 << k)) columns.push_back(k);
  const Eigen::Index n = v2.size(), m = static_cast<Eigen::Index>(columns.size());
  Eigen::MatrixXd a(n, m);
  for (Eigen::Index k = 0; k < m; ++k) a.col(k) = design.col(columns[static_cast<std::size_t>(k)]);

  Fit fit;
  const double scale = v2.mean();
  const double floor = 1e-9 * scale;
  Eigen::VectorXd variance = start;
  Eigen::VectorXd solution = Eigen::VectorXd::Zero(m);
  for (int iteration = 0; iteration < 60; ++iteration) {
    // Normal equations of rows divided by their variance, columns scaled to unit length.
    Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(m, m);
    Eigen::VectorXd right = Eigen::VectorXd::Zero(m);
    for (Eigen::Index i = 0; i < n; ++i) {
      const double w = 1.0 / (variance(i) * variance(i));
      for (Eigen::Index k = 0; k < m; ++k) {
        const double wa = w * a(i, k);
        right(k) += wa * v2(i);
        for (Eigen::Index l = 0; l <= k; ++l) normal(k, l) += wa * a(i, l);
      }
    }
    const Eigen::VectorXd norm = normal.diagonal().cwiseSqrt();
    if (!(norm.minCoeff() > 0)) return fit;
    const Eigen::VectorXd unit = norm.cwiseInverse();
    const Eigen::MatrixXd full = normal.selfadjointView<Eigen::Lower>();
    const Eigen::FullPivLU<Eigen::MatrixXd> lu(unit.asDiagonal() * full * unit.asDiagonal());
    if (lu.rcond() < 1e-10) return fit;  // the terms cannot be told apart (one range, say)
    const Eigen::VectorXd next =
        unit.asDiagonal() * lu.solve((unit.asDiagonal() * right).eval()).eval();
    const Eigen::VectorXd fitted = (a * next.cwiseMax(0.0)).cwiseMax(floor);
    const double change = ((fitted - variance).cwiseQuotient(variance)).cwiseAbs().maxCoeff();
    solution = next;
    // Damped in the logarithm: full steps can circle when a term spans many decades.
    for (Eigen::Index i = 0; i < n; ++i)
      variance(i) = iteration < 3 ? fitted(i) : std::sqrt(variance(i) * fitted(i));
    if (change < 1e-6) break;
  }
  if (solution.minCoeff() < 0) return fit;
  fit.deviance = 0;
  fit.variance.resize(static_cast<std::size_t>(n));
  const Eigen::VectorXd fitted = (a * solution).cwiseMax(floor);
  for (Eigen::Index i = 0; i < n; ++i) {
    fit.variance[static_cast<std::size_t>(i)] = fitted(i);
    fit.deviance += v2(i) / fitted(i) + std::log(fitted(i));
  }
  for (Eigen::Index k = 0; k < m; ++k)
    fit.coefficient[static_cast<std::size_t>(columns[static_cast<std::size_t>(k)])] = solution(k);
  return fit;
}

/// Best subset by the corrected Akaike criterion with `dof` degrees of freedom a record (the log
/// likelihood is -dof/2 deviance): a prediction is wanted, so a weak term rather stays; few rows
/// get few terms.
Fit fit_best(const Eigen::MatrixXd& design, const Eigen::VectorXd& v2, double dof) {
  Fit best;
  double best_score = std::numeric_limits<double>::infinity();
  const double n = static_cast<double>(v2.size());
  const Eigen::VectorXd start = local_mean(design, v2);
  for (int mask = 1; mask < (1 << terms); ++mask) {
    int count = 0;
    for (int k = 0; k < terms; ++k) count += (mask >> k) & 1;
    // The correction needs two rows more than terms; one term is always allowed.
    if (count > 1 && n < count + 2.0) continue;
    const double k = count;
    const double penalty = 2.0 * k + (n > k + 1.0 ? 2.0 * k * (k + 1.0) / (n - k - 1.0) : 0.0);
    Fit fit = fit_subset(design, v2, start, mask);
    const double score = dof * fit.deviance + penalty;
    if (score < best_score) {
      best_score = score;
      best = std::move(fit);
    }
  }
  return best;
}

}  // namespace

double NoiseLaw::variance(double signal_v, double gain) const {
  const double s = std::abs(signal_v);
  return base_v2 + adc_v2 / (gain * gain) + shot_v * s + relative2 * s * s;
}

NoiseLaw fit_law(const std::vector<double>& v2, const std::vector<double>& signal_v,
                 const std::vector<double>& gain) {
  NoiseLaw law;
  const std::size_t count = v2.size();
  std::vector<bool> good(count, true);
  for (int pass = 0; pass < 10; ++pass) {
    std::vector<std::size_t> row;
    for (std::size_t i = 0; i < count; ++i)
      if (good[i]) row.push_back(i);
    const auto n = static_cast<Eigen::Index>(row.size());
    Eigen::MatrixXd design(n, terms);
    Eigen::VectorXd seen(n);
    for (Eigen::Index k = 0; k < n; ++k) {
      const std::size_t i = row[static_cast<std::size_t>(k)];
      const double s = std::abs(signal_v[i]);
      design.row(k) << 1.0, 1.0 / (gain[i] * gain[i]), s, s * s;
      seen(k) = v2[i];
    }
    law.rows = row.size();
    law.outliers = count - row.size();
    if (n == 0 || seen.maxCoeff() <= 0) return law;  // no scatter at all
    const Fit fit = fit_best(design, seen, law.dof);
    law.base_v2 = fit.coefficient[0];
    law.adc_v2 = fit.coefficient[1];
    law.shot_v = fit.coefficient[2];
    law.relative2 = fit.coefficient[3];
    if (n < 20) return law;  // too few to judge their own spread

    // The cube root of a chi-square variate over its mean is nearly normal, 1 - 2/9ν ± √(2/9ν).
    std::vector<double> root(count);
    std::vector<double> good_root;
    for (std::size_t i = 0; i < count; ++i) {
      root[i] = std::cbrt(v2[i] / std::max(law.variance(signal_v[i], gain[i]), 1e-300));
      if (good[i]) good_root.push_back(root[i]);
    }
    const double centre = formats::median(good_root);
    const double spread = (formats::interpolated_quantile(good_root, 0.75) -
                           formats::interpolated_quantile(good_root, 0.25)) /
                          1.349;
    if (!(centre > 0) || !(spread > 0)) return law;
    const double relative = spread / centre;
    // Solve √(2/9ν)/(1 - 2/9ν) = relative for q = 2/9ν.
    const double root_q = (std::sqrt(1.0 + 4.0 * relative * relative) - 1.0) / (2.0 * relative);
    law.dof = std::clamp(2.0 / (9.0 * root_q * root_q), 2.0, 1000.0);
    bool changed = false;
    for (std::size_t i = 0; i < count; ++i) {
      const bool now_good = root[i] - centre < outlier_z * spread;
      changed = changed || now_good != good[i];
      good[i] = now_good;
    }
    if (!changed && pass > 0) return law;
  }
  return law;
}

}  // namespace umov::calibrate
