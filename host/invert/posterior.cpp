#include "host/invert/posterior.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "host/optics/angles.hpp"

namespace umov::invert {
namespace {

constexpr double sigmas_95 = 1.959963984540054;
/// Limits farther away than this many sigma are out of reach.
constexpr double reach_sigmas = 4.5;
constexpr int sample_count = 4000;

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

class Draw {
 public:
  explicit Draw(std::uint64_t seed) : engine_(seed) {}
  double uniform() { return (static_cast<double>(engine_() >> 11) + 0.5) * 0x1.0p-53; }
  double normal() {
    return std::sqrt(-2 * std::log(uniform())) * std::cos(2 * optics::pi * uniform());
  }
  /// Standard normal within [a, b] (Robert 1995: exponential or uniform proposals in the tails).
  double normal_within(double a, double b) {
    if (a > b) return 0.5 * (a + b);
    if (b < 0) return -normal_within(-b, -a);
    if (a < 0.5 && b > 0 && b - a > 1.5) {
      for (;;) {
        const double z = normal();
        if (z >= a && z <= b) return z;
      }
    }
    if (a > 0.5 && b - a > 2 / a) {
      const double rate = 0.5 * (a + std::sqrt(a * a + 4));
      for (;;) {
        const double z = a - std::log(uniform()) / rate;
        if (z <= b && uniform() <= std::exp(-0.5 * (z - rate) * (z - rate))) return z;
      }
    }
    const double peak = a > 0 ? a : 0;
    for (;;) {
      const double z = a + (b - a) * uniform();
      if (uniform() <= std::exp(0.5 * (peak * peak - z * z))) return z;
    }
  }

 private:
  std::mt19937_64 engine_;
};

Interval quantiles(std::vector<double> values, double lower, double upper) {
  const auto at = [&](double share) {
    const auto index = static_cast<long>(share * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), values.begin() + index, values.end());
    return values[static_cast<std::size_t>(index)];
  };
  return {at(lower), at(upper)};
}

}  // namespace

Posterior::Posterior(const Layout& layout, const Observations& data, const Solution& solution,
                     Objective objective, double scale, double huber_sigma, std::uint64_t seed)
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
  const Linearisation at =
      linearise(layout, data, solution.x, c, {.scale = scale, .huber_sigma = huber});

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
  sample_within_limits(centre, seed);
}

double Posterior::sigma(std::size_t free) const {
  const auto i = static_cast<Eigen::Index>(free);
  return std::sqrt(covariance_(i, i));
}

void Posterior::sample_within_limits(const Eigen::VectorXd& centre, std::uint64_t seed) {
  const auto n = static_cast<Eigen::Index>(x_.size());
  Eigen::VectorXd lo(n), hi(n);
  std::vector<Eigen::Index> near, far;
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto free = static_cast<std::size_t>(i);
    const Coordinate& k = layout_.free()[free].coordinate;
    lo[i] = k.lo_x() - x_[free];
    hi[i] = k.hi_x() - x_[free];
    const double reach = reach_sigmas * sigma(free);
    const bool within =
        std::min(centre[i], 0.0) - reach < lo[i] || std::max(centre[i], 0.0) + reach > hi[i];
    (within ? near : far).push_back(i);
  }
  if (near.empty()) return;

  // The parameters near limits by Gibbs sampling of their own marginal distribution: steps along
  // each parameter, which a corner of the box cannot block, and along each principal axis, which
  // strong correlation cannot slow down.
  const auto count = static_cast<Eigen::Index>(near.size());
  const Eigen::VectorXd unit = covariance_.diagonal()(near).cwiseSqrt();
  const Eigen::MatrixXd correlation =
      unit.cwiseInverse().asDiagonal() * covariance_(near, near) * unit.cwiseInverse().asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(correlation);
  const Eigen::VectorXd values = eigen.eigenvalues().cwiseMax(1e-12);
  const Eigen::MatrixXd precision =
      eigen.eigenvectors() * values.cwiseInverse().asDiagonal() * eigen.eigenvectors().transpose();
  Eigen::MatrixXd directions(count, 2 * count);
  directions << Eigen::MatrixXd::Identity(count, count), eigen.eigenvectors();
  const Eigen::VectorXd from = lo(near).cwiseQuotient(unit), to = hi(near).cwiseQuotient(unit);
  const Eigen::VectorXd middle = centre(near).cwiseQuotient(unit);

  // The others follow: normal, given these.
  const Eigen::MatrixXd near_inverse =
      unit.cwiseInverse().asDiagonal() * precision * unit.cwiseInverse().asDiagonal();
  const Eigen::MatrixXd regression = covariance_(far, near) * near_inverse;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> rest(covariance_(far, far) -
                                                            regression * covariance_(near, far));
  const Eigen::MatrixXd spread =
      far.empty() ? Eigen::MatrixXd()
                  : Eigen::MatrixXd(rest.eigenvectors() *
                                    rest.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal());

  Draw draw(seed ^ 0xC0FFEE5EEDULL);
  Eigen::VectorXd z = Eigen::VectorXd::Zero(count);  // in sigmas from the optimum
  draws_.resize(sample_count, n);
  constexpr int warm_up = 400;
  for (int step = -warm_up; step < sample_count; ++step) {
    for (Eigen::Index d = 0; d < directions.cols(); ++d) {
      const auto direction = directions.col(d);
      double left = -1e6, right = 1e6;
      for (Eigen::Index i = 0; i < count; ++i) {
        if (std::abs(direction[i]) < 1e-12) continue;
        const double a = (from[i] - z[i]) / direction[i], b = (to[i] - z[i]) / direction[i];
        left = std::max(left, std::min(a, b));
        right = std::min(right, std::max(a, b));
      }
      if (!(left < right)) continue;
      const Eigen::VectorXd weighed = precision * direction;
      const double width = 1 / std::sqrt(direction.dot(weighed));
      const double best = weighed.dot(middle - z) * width * width;
      z += direction *
           (best + width * draw.normal_within((left - best) / width, (right - best) / width));
      z = z.cwiseMax(from).cwiseMin(to);
    }
    if (step < 0) continue;
    const Eigen::VectorXd moved = z.cwiseProduct(unit);
    for (Eigen::Index i = 0; i < count; ++i)
      draws_(step, near[static_cast<std::size_t>(i)]) = moved[i];
    if (far.empty()) continue;
    Eigen::VectorXd noise(static_cast<Eigen::Index>(far.size()));
    for (double& value : noise) value = draw.normal();
    const Eigen::VectorXd others =
        centre(far) + regression * (moved - centre(near)) + spread * noise;
    for (std::size_t i = 0; i < far.size(); ++i)
      draws_(step, far[i]) = others[static_cast<Eigen::Index>(i)];
  }
}

Interval Posterior::interval(double value, const Eigen::VectorXd& by_x) const {
  const double s = std::sqrt(std::max(0.0, by_x.dot(covariance_ * by_x)));
  const Interval plain{value - sigmas_95 * s, value + sigmas_95 * s};
  if (draws_.rows() == 0 || s == 0) return plain;
  const Eigen::VectorXd d = draws_ * by_x;
  const double mean = d.mean();
  const double spread = std::sqrt((d.array() - mean).square().mean());
  // Where the limits change nothing the exact interval is better than one from draws.
  if (std::abs(mean) < 0.06 * s && std::abs(spread / s - 1) < 0.04) return plain;
  const Interval q = quantiles(std::vector<double>(d.begin(), d.end()), 0.025, 0.975);
  return {value + std::min(q.lo, 0.0), value + std::max(q.hi, 0.0)};
}

Interval Posterior::parameter_interval(std::size_t free) const {
  const Coordinate& k = layout_.free()[free].coordinate;
  const auto i = static_cast<Eigen::Index>(free);
  Interval x = interval(x_[free], Eigen::VectorXd::Unit(static_cast<Eigen::Index>(x_.size()), i));
  if (draws_.rows() > 0) {
    // Mass piled up at a limit: all of the 5 % goes to the other side.
    const Eigen::VectorXd column = draws_.col(i);
    const std::vector<double> d(column.begin(), column.end());
    const Interval one_sided = quantiles(d, 0.05, 0.95);
    const double below = k.lo_x() - x_[free], above = k.hi_x() - x_[free];
    const double width = one_sided.hi - one_sided.lo;
    if (one_sided.lo - below < 0.1 * width) x = {k.lo_x(), x_[free] + std::max(one_sided.hi, 0.0)};
    if (above - one_sided.hi < 0.1 * width) x = {x_[free] + std::min(one_sided.lo, 0.0), k.hi_x()};
  }
  Interval out{k.lo, k.hi};
  // At the limits themselves the limit's own value, not that of the coordinate's safe stop.
  if (x.lo > k.lo_x()) out.lo = k.to_parameter(x.lo);
  if (x.hi < k.hi_x()) out.hi = k.to_parameter(x.hi);
  return out;
}

}  // namespace umov::invert
