// The noise of rays in a simulated change of a map, taken out as far as the change is smooth.
#pragma once

#include <vector>

#include <Eigen/Core>

namespace umov::gap {

/// Smooths values at the pixels of a map over their neighbours: at each pixel a plane is fitted to
/// what lies about it, with weights after Gauss, so that slopes stay and edges of the map pull
/// nothing.
///
/// A signature with noise of its own is not worth what it says: a fit takes it too small (the noise
/// dilutes the regression) and lets smoother, wrong signatures make up for the rest.
class Smoothing {
 public:
  /// Places in pixels.
  Smoothing(const std::vector<double>& x, const std::vector<double>& y);

  /// Mean of two independent estimates of one change, smoothed as widely as makes each of them
  /// foretell the other best: nothing is known of its shape but what both agree on.
  Eigen::VectorXd mean(const Eigen::VectorXd& one, const Eigen::VectorXd& other) const;

  /// Standard deviation of the weights in pixels that mean() chooses for these; 0: none.
  double width(const Eigen::VectorXd& one, const Eigen::VectorXd& other) const;

 private:
  std::size_t choose(const Eigen::VectorXd& one, const Eigen::VectorXd& other) const;

  std::vector<Eigen::MatrixXd> smooth_;  ///< by width
};

}  // namespace umov::gap
