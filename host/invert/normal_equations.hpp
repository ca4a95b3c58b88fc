// The objective with its gradient and Gauss-Newton curvature at one point.
#pragma once

#include <Eigen/Core>

#include "host/invert/minimise.hpp"

namespace umov::invert {

/// Objective r·r and, by coordinates and then factors, Jᵀr and JᵀJ. `finite` is false where the
/// model has no finite value or derivative.
struct NormalEquations {
  double objective = 0;
  Eigen::VectorXd gradient;
  Eigen::MatrixXd curvature;
  bool finite = true;
};
NormalEquations normal_equations(const Problem& problem, std::span<const double> x,
                                 std::span<const double> c);

}  // namespace umov::invert
