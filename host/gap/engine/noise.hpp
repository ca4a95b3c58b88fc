// The noise of a measurement: white noise of known size, and a slow relative noise (of a source,
// say) whose size and memory are learned from the measurement itself.
//
// Errors are e_i + s_i a_i with independent e_i of standard deviation sigma_i, and a_i a stationary
// first-order autoregression in the order of measurement: a_(i+1) = φ a_i + …, standard deviation
// r. Whitening by the Kalman filter of this model: linear, O(n) a column, the same for residuals
// and derivatives.
#pragma once

#include <vector>

#include <Eigen/Core>

namespace umov::gap {

/// What an adapter says of its noise.
struct NoiseShape {
  Eigen::VectorXd sigma;  ///< white part, one an observation
  /// Change of each observation for a relative change of one; zero where the slow noise does not
  /// act. Empty: there is none.
  Eigen::VectorXd slow;
  /// Observations in the order they were measured; those without slow noise may be missing.
  std::vector<Eigen::Index> order;
};

/// Size and memory of the slow noise.
struct SlowNoise {
  double size = 0;    ///< r, relative
  double memory = 0;  ///< φ, from one observation to the next
};

class Whitening {
 public:
  explicit Whitening(NoiseShape shape, SlowNoise slow = {}, double scale = 1.0);
  /// Columns with unit independent noise.
  Eigen::MatrixXd apply(const Eigen::MatrixXd& columns) const;
  /// Σ ln of the standard deviations whitened by.
  double ln_determinant() const { return ln_determinant_; }
  const NoiseShape& shape() const { return shape_; }
  const SlowNoise& slow() const { return slow_; }

 private:
  NoiseShape shape_;
  SlowNoise slow_;
  double scale_;
  /// Along the order: gain of the filter and inverse standard deviation of the innovation.
  std::vector<double> gain_, inverse_;
  double ln_determinant_ = 0;
};

/// Size and memory that make `residual` most likely when the span of `columns` is fitted to it
/// (restricted likelihood). Zero size where the likelihood gains less than 3.
SlowNoise learn_slow_noise(const NoiseShape& shape, const Eigen::VectorXd& residual,
                           const Eigen::MatrixXd& columns, double scale = 1.0);

}  // namespace umov::gap
