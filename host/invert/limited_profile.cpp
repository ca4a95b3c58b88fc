#include "host/invert/limited_profile.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <utility>

#include "host/invert/box_quadratic.hpp"

namespace umov::invert {
namespace {

/// Limits farther away than this many sigma are out of reach.
constexpr double reach_sigmas = 4.5;

}  // namespace

LimitedProfile::LimitedProfile(const Eigen::MatrixXd& covariance, const Eigen::VectorXd& centre,
                               const Eigen::VectorXd& lo, const Eigen::VectorXd& hi,
                               const std::vector<Hinge>& hinges)
    : centre_(centre) {
  const Eigen::VectorXd sigma = covariance.diagonal().cwiseSqrt();
  std::vector<bool> bent(static_cast<std::size_t>(centre.size()), false);
  for (const Hinge& hinge : hinges) {
    const double reach = reach_sigmas * std::sqrt(hinge.slope.dot(covariance * hinge.slope));
    if (std::max(hinge.value, hinge.value + hinge.slope.dot(centre)) + reach <= 0) continue;
    hinges_.push_back(hinge);
    for (Eigen::Index i = 0; i < centre.size(); ++i) {
      if (hinge.slope[i] != 0) bent[static_cast<std::size_t>(i)] = true;
    }
  }
  for (Eigen::Index i = 0; i < centre.size(); ++i) {
    const double reach = reach_sigmas * sigma[i];
    const bool within =
        std::min(centre[i], 0.0) - reach < lo[i] || std::max(centre[i], 0.0) + reach > hi[i];
    (within || bent[static_cast<std::size_t>(i)] ? near_ : far_).push_back(i);
  }
  if (near_.empty()) return;
  unit_ = sigma(near_);
  from_ = lo(near_).cwiseQuotient(unit_);
  to_ = hi(near_).cwiseQuotient(unit_);
  middle_ = centre(near_).cwiseQuotient(unit_);
  for (Hinge& hinge : hinges_) {
    hinge.slope = Eigen::VectorXd(hinge.slope(near_).cwiseProduct(unit_));
  }
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
  double sum = (z - middle_).dot(precision_ * (z - middle_));
  for (const Hinge& hinge : hinges_) {
    const double over = std::max(0.0, hinge.value + hinge.slope.dot(z));
    sum += over * over;
  }
  return sum;
}

/// Minimum of chi²(z) − 2 pull·z within the limits. Which hinges bend there is found by trying: a
/// convex function, so a set that reproduces itself is the right one.
Eigen::VectorXd LimitedProfile::minimise(const Eigen::VectorXd& pull,
                                         const Eigen::VectorXd& start) const {
  Eigen::VectorXd z = start;
  std::vector<bool> bent(hinges_.size(), false);
  for (int round = 0; round < 20; ++round) {
    Eigen::MatrixXd a = precision_;
    Eigen::VectorXd b = -(precision_ * middle_) - pull;
    for (std::size_t h = 0; h < hinges_.size(); ++h) {
      if (!bent[h]) continue;
      a += hinges_[h].slope * hinges_[h].slope.transpose();
      b += hinges_[h].value * hinges_[h].slope;
    }
    z = minimum_in_box(a, b, from_, to_, z);
    std::vector<bool> now(hinges_.size());
    for (std::size_t h = 0; h < hinges_.size(); ++h) {
      now[h] = hinges_[h].value + hinges_[h].slope.dot(z) > 0;
    }
    if (now == bent) break;
    bent = now;
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
