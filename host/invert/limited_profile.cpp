#include "host/invert/limited_profile.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <utility>

namespace umov::invert {
namespace {

/// Limits farther away than this many sigma are out of reach.
constexpr double reach_sigmas = 4.5;

}  // namespace

LimitedProfile::LimitedProfile(const Eigen::MatrixXd& covariance, const Eigen::VectorXd& centre,
                               const Eigen::VectorXd& lo, const Eigen::VectorXd& hi)
    : centre_(centre) {
  const Eigen::VectorXd sigma = covariance.diagonal().cwiseSqrt();
  for (Eigen::Index i = 0; i < centre.size(); ++i) {
    const double reach = reach_sigmas * sigma[i];
    const bool within =
        std::min(centre[i], 0.0) - reach < lo[i] || std::max(centre[i], 0.0) + reach > hi[i];
    (within ? near_ : far_).push_back(i);
  }
  if (near_.empty()) return;
  unit_ = sigma(near_);
  from_ = lo(near_).cwiseQuotient(unit_);
  to_ = hi(near_).cwiseQuotient(unit_);
  middle_ = centre(near_).cwiseQuotient(unit_);
  const Eigen::MatrixXd correlation = unit_.cwiseInverse().asDiagonal() * covariance(near_, near_) *
                                      unit_.cwiseInverse().asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(correlation);
  const Eigen::VectorXd values = eigen.eigenvalues().cwiseMax(1e-12);
  precision_ =
      eigen.eigenvectors() * values.cwiseInverse().asDiagonal() * eigen.eigenvectors().transpose();
  const Eigen::MatrixXd near_inverse =
      unit_.cwiseInverse().asDiagonal() * precision_ * unit_.cwiseInverse().asDiagonal();
  regression_ = covariance(far_, near_) * near_inverse;
  rest_ = covariance(far_, far_) - regression_ * covariance(near_, far_);
}

double LimitedProfile::chi2(const Eigen::VectorXd& z) const {
  return (z - middle_).dot(precision_ * (z - middle_));
}

/// Minimum of chi²(z) − 2 pull·z within the limits, by an active set: walk to the minimum of the
/// coordinates that are free, stop at the first limit met, let go of a limit that no longer holds.
Eigen::VectorXd LimitedProfile::minimise(const Eigen::VectorXd& pull, Eigen::VectorXd start) const {
  const Eigen::Index n = middle_.size();
  Eigen::VectorXd z = start.cwiseMax(from_).cwiseMin(to_);
  std::vector<int> held(static_cast<std::size_t>(n));  // −1 at its lower limit, +1 at its upper one
  for (Eigen::Index i = 0; i < n; ++i)
    held[static_cast<std::size_t>(i)] = z[i] <= from_[i] ? -1 : z[i] >= to_[i] ? 1 : 0;
  const int most_steps = 20 * static_cast<int>(n) + 20;
  for (int step = 0; step < most_steps; ++step) {
    const Eigen::VectorXd slope = precision_ * (z - middle_) - pull;
    std::vector<Eigen::Index> free;
    for (Eigen::Index i = 0; i < n; ++i)
      if (held[static_cast<std::size_t>(i)] == 0) free.push_back(i);
    double length = 1;
    Eigen::Index blocking = -1;
    if (!free.empty()) {
      const Eigen::MatrixXd block = precision_(free, free);
      const Eigen::VectorXd move = -block.ldlt().solve(slope(free));
      for (std::size_t k = 0; k < free.size(); ++k) {
        const Eigen::Index i = free[k];
        const double d = move[static_cast<Eigen::Index>(k)];
        const double room = d > 0 ? to_[i] - z[i] : from_[i] - z[i];
        if (d != 0 && room / d < length) {
          length = room / d;
          blocking = i;
        }
      }
      for (std::size_t k = 0; k < free.size(); ++k)
        z[free[k]] += length * move[static_cast<Eigen::Index>(k)];
    }
    if (blocking >= 0) {
      const bool upper =
          std::abs(z[blocking] - to_[blocking]) < std::abs(z[blocking] - from_[blocking]);
      z[blocking] = upper ? to_[blocking] : from_[blocking];
      held[static_cast<std::size_t>(blocking)] = upper ? 1 : -1;
      continue;
    }
    const Eigen::VectorXd there = precision_ * (z - middle_) - pull;
    Eigen::Index release = -1;
    double worst = 1e-9 * (1 + pull.cwiseAbs().maxCoeff());
    for (Eigen::Index i = 0; i < n; ++i) {
      const double outward =
          -there[i] * held[static_cast<std::size_t>(i)];  // < 0: wants back inside
      if (-outward > worst) {
        worst = -outward;
        release = i;
      }
    }
    if (release < 0) break;
    held[static_cast<std::size_t>(release)] = 0;
  }
  return z;
}

double LimitedProfile::extreme(const Eigen::VectorXd& by_x, int side, double rise) const {
  const Eigen::VectorXd direction = side * by_x;
  const Eigen::VectorXd far_gradient = direction(far_);
  const Eigen::VectorXd along =
      unit_.cwiseProduct(direction(near_) + regression_.transpose() * far_gradient);
  const double far_variance = std::max(0.0, far_gradient.dot(rest_ * far_gradient));
  const double fixed = far_gradient.dot(centre_(far_) - regression_ * centre_(near_));

  // The extreme of the quantity at a given rise is where chi² − 2 λ·quantity is least, for the λ
  // that makes the rise so.
  const Eigen::VectorXd best =
      minimise(Eigen::VectorXd::Zero(along.size()), Eigen::VectorXd::Zero(along.size()));
  const double least = chi2(best);
  const auto at = [&](double lambda) {
    const Eigen::VectorXd z = minimise(lambda * along, best);
    return std::pair{fixed + along.dot(z) + lambda * far_variance,
                     chi2(z) - least + lambda * lambda * far_variance};
  };
  const double spread = std::sqrt(along.squaredNorm() + far_variance);
  if (spread == 0) return side * at(0).first;
  double low = 0, high = std::sqrt(rise) / spread;
  for (int doubling = 0; doubling < 60 && at(high).second < rise; ++doubling) {
    low = high;
    high *= 2;
  }
  for (int halving = 0; halving < 50; ++halving) {
    const double middle = 0.5 * (low + high);
    (at(middle).second < rise ? low : high) = middle;
  }
  return side * at(low).first;
}

}  // namespace umov::invert
