// The noise of a measurement: white noise of known size, and a relative noise (of a source, say),
// partly white and partly slow, whose sizes and memory are learned from the measurement itself.
//
// Errors are e_i + s_i (w_i + a_i) with independent e_i of standard deviation sigma_i, independent
// w_i of standard deviation w, and a_i a stationary first-order autoregression in the order of
// measurement: a_(i+1) = φ a_i + …, standard deviation r. Whitening by the Kalman filter of this
// model: linear, O(n) a column, the same for residuals and derivatives.
#pragma once

#include <vector>

#include <Eigen/Core>

namespace umov::gap {

/// What an adapter says of its noise.
struct NoiseShape {
  Eigen::VectorXd sigma;  ///< white part, one an observation
  /// Change of each observation for a relative change of one; zero where the relative noise does
  /// not act. Empty: there is none.
  Eigen::VectorXd relative;
  /// Observations in the order they were measured; those without relative noise may be missing.
  std::vector<Eigen::Index> order;
};

/// Sizes and memory of the relative noise.
struct RelativeNoise {
  double white = 0;   ///< w, of one observation
  double slow = 0;    ///< r
  double memory = 0;  ///< φ, from one observation to the next
};

class Whitening {
 public:
  explicit Whitening(NoiseShape shape, RelativeNoise relative = {}, double scale = 1.0);
  /// Columns with unit independent noise.
  Eigen::MatrixXd apply(const Eigen::MatrixXd& columns) const;
  /// Σ ln of the standard deviations whitened by.
  double ln_determinant() const { return ln_determinant_; }
  const NoiseShape& shape() const { return shape_; }
  const RelativeNoise& relative() const { return relative_; }
  /// Standard deviation of each observation's white part.
  const Eigen::VectorXd& white_sigma() const { return white_sigma_; }

 private:
  NoiseShape shape_;
  RelativeNoise relative_;
  Eigen::VectorXd white_sigma_;
  /// Along the order: gain of the filter and inverse standard deviation of the innovation.
  std::vector<double> gain_, inverse_;
  double ln_determinant_ = 0;
};

/// Sizes and memory that make `residual` most likely. `fitted`: degrees of freedom that were taken
/// from it by fits. Zero sizes where the likelihood gains too little.
RelativeNoise learn_relative_noise(const NoiseShape& shape, const Eigen::VectorXd& residual,
                                   double fitted, double scale = 1.0);

}  // namespace umov::gap
