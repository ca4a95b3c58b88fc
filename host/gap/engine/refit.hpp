// Fitting base parameters and effects together, within their bounds and priors.
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "host/gap/engine/forward_model.hpp"

namespace umov::gap {

/// An explanation at its best values.
struct Refit {
  Explanation explanation;
  Eigen::VectorXd residual;         ///< value - mean, whitened
  Eigen::MatrixXd jacobian;         ///< d mean / d parameter, whitened
  Eigen::VectorXd mean;             ///< predicted values
  Eigen::MatrixXd precision;        ///< of all parameters: Jᵀ J and priors
  Eigen::VectorXd prior_precision;  ///< of each parameter
  /// Parameters that can move: not choices, not held at a bound that they would cross.
  std::vector<Eigen::Index> free;
  double chi2 = 0;     ///< of the data
  double penalty = 0;  ///< of the priors
  /// False: the derivatives of some parameters are those of a fit nearby.
  bool own_derivatives = true;
};

/// The base model as it stands before any fit.
Explanation base_explanation(const ForwardModel& model);

/// Weighted least squares from `start`, with a noise that does not follow the fit (it would reward
/// a model for predicting noise). Parameters keep inside their bounds. Throws umov::Error where the
/// model gives values that are not numbers.
///
/// With `near`, a fit under the same whitening whose parameters are not far: its derivatives serve
/// for the parameters that both have. Ten times faster where few are new, near the minimum as far
/// as the model is straight between the two.
/// `held`: parameters (numbers, the base's first) that keep their values.
Refit refit(const ForwardModel& model, const Explanation& start, const Whitening& whitening,
            int max_iterations = 40, const Refit* near = nullptr,
            const std::vector<Eigen::Index>& held = {});

/// The same explanation with one effect more, in its place of the order.
Explanation with_effect(const Explanation& explanation, std::size_t effect,
                        const std::vector<double>& alpha);
/// The same explanation with one effect less.
Explanation without_effect(const Explanation& explanation, std::size_t effect);

/// What χ² would rise by without one effect of the fit (its `place`), by the curvature at the fit,
/// all else free: within a factor of four of what a refit would find.
double worth_by_curvature(const ForwardModel& model, const Refit& fit, std::size_t place);

/// Orthonormal directions, as columns, that a fit's free parameters can follow. Rows: the
/// observations, then the free parameters themselves, of which priors are further observations.
Eigen::MatrixXd followed_directions(const Refit& fit);

/// One standard error of each parameter from a fit's precision, the others free; 0 where the data
/// and priors say nothing (a choice).
Eigen::VectorXd standard_errors(const Eigen::MatrixXd& precision);

}  // namespace umov::gap
