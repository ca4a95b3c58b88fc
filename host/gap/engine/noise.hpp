// The noise of a measurement: white noise of known size, and errors in proportion to the signal
// whose sizes are learned from the measurement itself: new in every observation, slow, or fixed to
// the place that is looked at.
//
// Errors are e_i + s_i (w_i + a_i + p_g(i)) with independent e_i of standard deviation sigma_i,
// independent w_i of standard deviation w, a_i a stationary first-order autoregression in the order
// of measurement (a_(i+1) = φ a_i + …, standard deviation r), and p_g of standard deviation p, one
// for each place g: the same again wherever a place is measured again. Whitening by the Kalman
// filter of w and a, then of p among the observations of each place: linear, O(n) a column, the
// same for residuals and derivatives; exact where no place repeats or r = 0, and near it where r is
// small against the noise of one observation.
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
  /// Groups of observations that look at the same place; those of places seen once are in none.
  std::vector<std::vector<Eigen::Index>> same_place = {};
  /// One standard error of sigma², over the squared signal of those that the noise hides least.
  double doubt = 0;
};

/// Sizes and memory of the relative noise.
struct RelativeNoise {
  double white = 0;    ///< w, of one observation
  double slow = 0;     ///< r
  double memory = 0;   ///< φ, from one observation to the next
  double pattern = 0;  ///< p, of one place
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
  /// Standard deviation of each observation's white part, the pattern included.
  const Eigen::VectorXd& white_sigma() const { return white_sigma_; }

 private:
  NoiseShape shape_;
  RelativeNoise relative_;
  Eigen::VectorXd white_sigma_;
  /// Along the order: gain of the filter and inverse standard deviation of the innovation.
  std::vector<double> gain_, inverse_;
  /// Along each place that is seen more than once: which observation, what its predecessors say of
  /// it, and the inverse standard deviation of what they do not.
  struct Again {
    Eigen::Index observation;
    double share;    ///< of the pattern in the whitened observation
    double gain;     ///< of the filter
    double inverse;  ///< of the innovation's standard deviation
    bool first;      ///< of its place
  };
  void follow_places();
  std::vector<Again> again_;
  double ln_determinant_ = 0;
};

/// Twice the negative log-likelihood of `residual`, up to a constant. `kept`: share of each
/// observation's variance that fits have left in it.
double misfit(const NoiseShape& shape, const Eigen::VectorXd& residual, const Eigen::VectorXd& kept,
              const RelativeNoise& noise, double scale = 1.0);

/// Sizes and memory that make `residual` most likely; `kept` as above. Zero sizes where the
/// likelihood gains too little.
RelativeNoise learn_relative_noise(const NoiseShape& shape, const Eigen::VectorXd& residual,
                                   const Eigen::VectorXd& kept, double scale = 1.0);

}  // namespace umov::gap
