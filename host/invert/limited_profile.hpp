// Intervals of quantities when parameters have limits: profile likelihood of a quadratic in a box.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace umov::invert {

/// A limit that gives way: adds max(0, value + slope·d)² to chi² at the offset d.
struct Hinge {
  double value = 0;
  Eigen::VectorXd slope;
};

/// A normal likelihood of n coordinates, of which some can reach their limits. All positions are
/// offsets from the constrained optimum.
///
/// A quantity's 95 % interval holds every value that the likelihood, maximised over everything else
/// within the limits, rates within 1.92 of its best (3.84 in chi²). On and near a limit this covers
/// between .94 and .97, where a distribution cut off at the limit covers as little as .77 and the
/// curvature at the optimum as little as .84 (two parameters, correlation .95).
class LimitedProfile {
 public:
  /// Everything is within reach of no limit.
  LimitedProfile() = default;
  /// `centre`: the optimum if there were no limits and hinges; `lo` and `hi`: the limits.
  LimitedProfile(const Eigen::MatrixXd& covariance, const Eigen::VectorXd& centre,
                 const Eigen::VectorXd& lo, const Eigen::VectorXd& hi,
                 const std::vector<Hinge>& hinges = {});

  /// False where no limit matters; then extreme() must not be asked.
  bool limited() const { return !near_.empty(); }
  /// Largest (side +1) or smallest (side −1) offset of the quantity with gradient `by_x` whose
  /// chi² lies within `rise` of the best.
  double extreme(const Eigen::VectorXd& by_x, int side, double rise) const;

 private:
  Eigen::VectorXd minimise(const Eigen::VectorXd& pull, const Eigen::VectorXd& start) const;
  double chi2(const Eigen::VectorXd& z) const;

  std::vector<Eigen::Index> near_, far_;  ///< coordinates that can reach a limit, and the others
  Eigen::VectorXd centre_;
  std::vector<Hinge> hinges_;  ///< those in reach, by the near coordinates in their sigmas
  // Of the near coordinates, in their sigmas:
  Eigen::VectorXd unit_, from_, to_, middle_;
  Eigen::MatrixXd precision_;
  // Of the far ones given the near ones:
  Eigen::MatrixXd regression_, rest_;
};

}  // namespace umov::invert
