// Minimisers: bounded least squares over all wavelengths, and (P12) by BFGS.
#pragma once

#include <span>
#include <vector>

#include "host/invert/prior.hpp"
#include "host/invert/residuals.hpp"

namespace umov::invert {

/// What is minimised. Refers to its parts; they must outlive it.
struct Problem {
  const Layout& layout;
  const Observations& data;
  const Priors& priors;
  Weighting weighting = {};
};

struct Solution {
  std::vector<double> x;  ///< coordinates, within their limits
  std::vector<double> c;  ///< factors in standard deviations
  double objective = 0;   ///< Σ r² + Σ c² + the priors' terms, or F of (P12)
  int iterations = 0;     ///< evaluations of all residuals with derivatives
  bool converged = false;
};

/// When a descent is over.
struct Stop {
  int max_iterations = 200;
  /// Neither the last step nor the next one (as its quadratic foretells) lowers the objective by
  /// more than this share.
  double function_tolerance = 1e-9;
  /// Damping of the first step relative to each coordinate's curvature. Little for starts that come
  /// from a descent on fewer points.
  double first_damping = 1e-3;
};

/// Objective at a point: Σ r² + Σ c² + the priors' terms; infinite where the model is not finite.
double objective_at(const Problem& problem, std::span<const double> x, std::span<const double> c);

/// Levenberg-Marquardt with limits on x. Each step is the minimum within the limits of the local
/// quadratic, damped only in the coordinates that are not marked in `linear` (by parameter of the
/// model; see linear_parameters): the coefficients in which the model is linear are thereby
/// eliminated, as in variable projection. The factors c have unit normal priors.
Solution least_squares(const Problem& problem, std::vector<double> x, std::vector<double> c,
                       const std::vector<bool>& linear, const Stop& stop);

/// Least squares with a robust loss whose scale follows the residuals: where the model misses by
/// more than the noise, the loss and the intervals are widened in step. With huber_sigma = 0 plain
/// least squares. `scale` is the final one, 1 where the noise explains the residuals.
struct RobustSolution {
  Solution solution;
  double scale = 1;
};
RobustSolution robust_least_squares(const Layout& layout, const Observations& data,
                                    const Priors& priors, std::vector<double> x,
                                    std::vector<double> c, const std::vector<bool>& linear,
                                    double huber_sigma, int max_iterations);

/// F = (1/N) Σ_λ Σ [(f − y)/y]² by BFGS with a Wolfe line search; limits by a logistic
/// substitution. No factors. Measured values must not be 0.
Solution paper_bfgs(const Layout& layout, const Observations& data, std::vector<double> x,
                    int max_iterations);

/// Scale of the residuals at a solution, before it is decided whether it differs from 1.
double measured_scale(const Layout& layout, const Observations& data, const Solution& solution,
                      double huber_sigma);

/// True where chi²/dof of this size is more than chance: above 1 by over four standard deviations.
bool exceeds_noise(double scale, std::size_t points, std::size_t free_parameters);

}  // namespace umov::invert
