// Minimum of a convex quadratic between limits: the step of a bounded fit, and its profile.
#pragma once

#include <Eigen/Core>

namespace umov::invert {

/// The p in [lo, hi] that minimises ½ pᵀ A p + bᵀ p, by an active set: walk to the minimum of the
/// coordinates that are free, stop at the first limit met, let go of a limit that no longer holds.
/// `a` symmetric and positive semi-definite, `start` is brought within the limits first.
Eigen::VectorXd minimum_in_box(const Eigen::MatrixXd& a, const Eigen::VectorXd& b,
                               const Eigen::VectorXd& lo, const Eigen::VectorXd& hi,
                               const Eigen::VectorXd& start);

}  // namespace umov::invert
