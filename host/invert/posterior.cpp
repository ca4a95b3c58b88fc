#include "host/invert/posterior.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <vector>

namespace umov::invert {
namespace {

constexpr double sigmas_95 = 1.959963984540054;
/// Rise of chi² at the ends of a 95 % interval, one parameter.
constexpr double rise_95 = sigmas_95 * sigmas_95;

/// Inverse of jᵀj + diag(1/range²) by the singular values of a well-scaled, triangular j.
Eigen::MatrixXd inverse_information(const Eigen::MatrixXd& j, const Eigen::VectorXd& range) {
  const Eigen::Index n = j.cols();
  Eigen::MatrixXd stacked(j.rows() + n, n);
  stacked.topRows(j.rows()) = j;
  stacked.bottomRows(n) = range.cwiseInverse().asDiagonal();
  const Eigen::VectorXd norm = stacked.colwise().norm();
  stacked = stacked * norm.cwiseInverse().asDiagonal();
  const Eigen::MatrixXd triangle = Eigen::HouseholderQR<Eigen::MatrixXd>(stacked)
                                       .matrixQR()
                                       .topRows(n)
                                       .triangularView<Eigen::Upper>();
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(triangle, Eigen::ComputeThinV);
  const Eigen::VectorXd inverse = svd.singularValues().cwiseMax(1e-300).cwiseInverse();
  const Eigen::MatrixXd half =
      norm.cwiseInverse().asDiagonal() * svd.matrixV() * inverse.asDiagonal();
  return half * half.transpose();
}

/// Priors are rows like any other measurement; orders, which only count where violated, are left to
/// the profile.
void append(const Priors::Rows& prior, Linearisation& at) {
  const Eigen::Index rows = at.r.size(), more = prior.r.size();
  at.r.conservativeResize(rows + more);
  at.by_x.conservativeResize(rows + more, Eigen::NoChange);
  at.by_c.conservativeResize(rows + more, Eigen::NoChange);
  at.r.tail(more) = prior.r;
  at.by_x.bottomRows(more) = prior.by_x;
  at.by_c.bottomRows(more).setZero();
}

}  // namespace

Posterior::Posterior(const Layout& layout, const Observations& data, const Priors& priors,
                     const Solution& solution, Objective objective, double scale,
                     double huber_sigma)
    : layout_(layout), x_(solution.x) {
  const auto n = static_cast<Eigen::Index>(layout.size());
  const auto factors = static_cast<Eigen::Index>(
      objective == Objective::paper ? data.factor_names.size() : solution.c.size());
  const std::vector<double> c =
      objective == Objective::paper ? std::vector<double>(data.factor_names.size()) : solution.c;
  Eigen::VectorXd range(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Coordinate& k = layout.free()[static_cast<std::size_t>(i)].coordinate;
    range[i] = k.hi_x() - k.lo_x();
  }
  const double huber = objective == Objective::paper ? 0 : huber_sigma;
  Linearisation at = linearise(layout, data, solution.x, c, {.scale = scale, .huber_sigma = huber});
  if (!priors.empty()) append(priors.normal_rows(solution.x), at);

  // Noise-weighted information on parameters and factors together.
  given_calibration_ = inverse_information(at.by_x, range);
  Eigen::MatrixXd joint(at.by_x.rows(), n + factors);
  joint << at.by_x, at.by_c;
  Eigen::VectorXd widths(n + factors);
  widths << range, Eigen::VectorXd::Ones(factors);  // the factors' priors have unit width
  const Eigen::MatrixXd all = inverse_information(joint, widths);
  covariance_ = all.topLeftCorner(n, n);
  factor_sigma_ = all.diagonal().tail(factors).cwiseSqrt();
  Eigen::VectorXd centre = -covariance_ * (at.by_x.transpose() * at.r);
  if (factors > 0) {
    const Eigen::Map<const Eigen::VectorXd> prior(c.data(), factors);
    centre -= all.topRightCorner(n, factors) * (at.by_c.transpose() * at.r + prior);
  }

  if (objective == Objective::paper) {
    // Relative deviations are not weighed by their noise: variance M (Jᵀ V J) M with M = (JᵀJ)⁻¹,
    // directions that relative deviations do not see keep the range.
    const Linearisation flat = linearise(layout, data, solution.x, c, {.relative = true});
    // A parameter pressed against a limit stays there whatever the noise: the others move without
    // it, and its own interval is the one-sided one of the noise-weighted information.
    Eigen::VectorXd span = range;
    std::vector<Eigen::Index> pressed;
    for (Eigen::Index i = 0; i < n; ++i) {
      const auto free = static_cast<std::size_t>(i);
      const Coordinate& k = layout.free()[free].coordinate;
      if (x_[free] > k.lo_x() && x_[free] < k.hi_x()) continue;
      span[i] = 0;
      pressed.push_back(i);
    }
    const Eigen::VectorXd own = covariance_.diagonal();
    const Eigen::MatrixXd j = flat.by_x * span.asDiagonal();
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(j, Eigen::ComputeThinU | Eigen::ComputeThinV);
    Eigen::VectorXd inverse(n), unseen(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const bool seen = svd.singularValues()[i] > 1e-8 * svd.singularValues()[0];
      inverse[i] = seen ? 1 / svd.singularValues()[i] : 0;
      unseen[i] = seen ? 0 : 1;
    }
    const Eigen::MatrixXd gain = span.asDiagonal() * svd.matrixV() * inverse.asDiagonal() *
                                 svd.matrixU().transpose();  // dx per unit of relative deviation
    Eigen::VectorXd noise(j.rows());
    Eigen::Index row = 0;
    for (const Spectrum& spectrum : data.spectra) {
      for (const Observation& point : spectrum.points) {
        noise[row++] = scale * point.sigma / point.brdf_per_sr;
      }
    }
    const Eigen::MatrixXd by_noise = gain * noise.asDiagonal();
    const Eigen::MatrixXd open = span.asDiagonal() * svd.matrixV() * unseen.asDiagonal();
    given_calibration_ = by_noise * by_noise.transpose() + open * open.transpose();
    covariance_ = given_calibration_;
    if (factors > 0) {
      const Eigen::MatrixXd by_factor = gain * flat.by_c;
      covariance_ += by_factor * by_factor.transpose();
    }
    factor_sigma_.setOnes();
    centre = -gain * flat.r;
    for (const Eigen::Index i : pressed) {
      covariance_(i, i) += own[i];
      given_calibration_(i, i) += own[i];
    }
  }
  centre_ = centre;
  Eigen::VectorXd lo(n), hi(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto free = static_cast<std::size_t>(i);
    const Coordinate& k = layout.free()[free].coordinate;
    lo[i] = k.lo_x() - x_[free];
    hi[i] = k.hi_x() - x_[free];
  }
  if (!priors.empty()) hinges_ = priors.hinges(solution.x);
  profile_ = LimitedProfile(covariance_, centre, lo, hi, hinges_);
}

Interval interval_95(const LimitedProfile& profile, const Eigen::MatrixXd& covariance, double value,
                     const Eigen::VectorXd& by_x) {
  const double s = std::sqrt(std::max(0.0, by_x.dot(covariance * by_x)));
  if (!profile.limited() || s == 0) return {value - sigmas_95 * s, value + sigmas_95 * s};
  return {value + std::min(profile.extreme(by_x, -1, rise_95), 0.0),
          value + std::max(profile.extreme(by_x, +1, rise_95), 0.0)};
}

double Posterior::sigma(std::size_t free) const {
  const auto i = static_cast<Eigen::Index>(free);
  return std::sqrt(covariance_(i, i));
}

Interval Posterior::interval(double value, const Eigen::VectorXd& by_x) const {
  return interval_95(profile_, covariance_, value, by_x);
}

Interval Posterior::parameter_interval(std::size_t free) const {
  const Coordinate& k = layout_.free()[free].coordinate;
  const auto i = static_cast<Eigen::Index>(free);
  const Interval x =
      interval(x_[free], Eigen::VectorXd::Unit(static_cast<Eigen::Index>(x_.size()), i));
  Interval out{k.lo, k.hi};
  // At the limits themselves the limit's own value, not that of the coordinate's safe stop.
  const double within = 1e-9 * (k.hi_x() - k.lo_x());
  if (x.lo > k.lo_x() + within) out.lo = k.to_parameter(x.lo);
  if (x.hi < k.hi_x() - within) out.hi = k.to_parameter(x.hi);
  return out;
}

}  // namespace umov::invert
