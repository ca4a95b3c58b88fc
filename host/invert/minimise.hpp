// Minimisers: bounded least squares over all wavelengths, and (P12) by BFGS.
#pragma once

#include <span>
#include <vector>

#include "host/invert/residuals.hpp"

namespace umov::invert {

struct Solution {
  std::vector<double> x;  ///< coordinates, within their limits
  std::vector<double> c;  ///< factors in standard deviations
  double objective = 0;   ///< Σ r² + Σ c², or F of (P12)
  int iterations = 0;
  bool converged = false;
};

/// Levenberg-Marquardt with box limits on x. The factors c have unit normal priors.
Solution least_squares(const Layout& layout, const Observations& data, std::vector<double> x,
                       std::vector<double> c, const Weighting& weighting, int max_iterations);

/// Least squares with a robust loss whose scale follows the residuals: where the model misses by
/// more than the noise, the loss and the intervals are widened in step. With huber_sigma = 0 plain
/// least squares. `scale` is the final one, 1 where the noise explains the residuals.
struct RobustSolution {
  Solution solution;
  double scale = 1;
};
RobustSolution robust_least_squares(const Layout& layout, const Observations& data,
                                    std::vector<double> x, std::vector<double> c,
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
