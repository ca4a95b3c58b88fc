// What the data leave open about the parameters: covariance, bounds taken into account, intervals.
#pragma once

#include <Eigen/Core>

#include "host/invert/limited_profile.hpp"
#include "host/invert/minimise.hpp"

namespace umov::invert {

struct Interval {
  double lo = 0, hi = 0;
};

/// 95 % interval of a quantity with value `value` at the optimum and gradient `by_x`: by the
/// profile where a limit is in reach, else from the covariance.
Interval interval_95(const LimitedProfile& profile, const Eigen::MatrixXd& covariance, double value,
                     const Eigen::VectorXd& by_x);

/// The parameters' likelihood by linearising the residuals at the optimum: normal, within the
/// limits. Limits count as knowledge of a width: a direction that the data do not see at all has
/// the range as its standard deviation.
class Posterior {
 public:
  /// `scale` widens the noise (not the calibration's errors). The objective tells whether the
  /// optimum is an efficient one (noise-weighted) or not (paper), whose variance is that of a
  /// sandwich estimate.
  Posterior(const Layout& layout, const Observations& data, const Priors& priors,
            const Solution& solution, Objective objective, double scale, double huber_sigma);

  /// Covariance of the coordinates x, calibration included.
  const Eigen::MatrixXd& covariance() const { return covariance_; }
  /// The same with the calibration factors held: what this scan alone confounds.
  const Eigen::MatrixXd& covariance_given_calibration() const { return given_calibration_; }
  /// One sigma of each factor.
  const Eigen::VectorXd& factor_sigma() const { return factor_sigma_; }
  double sigma(std::size_t free) const;
  /// Where the optimum would be without limits and orders, as an offset from the solution.
  const Eigen::VectorXd& centre() const { return centre_; }
  const std::vector<Hinge>& hinges() const { return hinges_; }

  /// 95 % interval of a quantity with value `value` at the optimum and gradient `by_x`.
  Interval interval(double value, const Eigen::VectorXd& by_x) const;
  /// 95 % interval of a free parameter, in its own unit; reaches to a limit that the data allow.
  Interval parameter_interval(std::size_t free) const;

 private:
  const Layout& layout_;
  std::vector<double> x_;
  Eigen::MatrixXd covariance_, given_calibration_;
  Eigen::VectorXd factor_sigma_, centre_;
  std::vector<Hinge> hinges_;
  LimitedProfile profile_;
};

}  // namespace umov::invert
