// Uncertainty budget of reduced points (GUM): what contributes, by how much, and what interval
// follows.
#pragma once

#include <cstddef>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "host/calibrate/calibration.hpp"
#include "host/calibrate/reduce.hpp"

namespace umov::calibrate {

/// One input quantity's share of a point's uncertainty. Where inputs are correlated each carries
/// what those before it in the list do not explain, so that squares add up.
struct Contribution {
  std::string name;  ///< "noise", "gain", "instrument function", "reference standard" …
  char type = 'B';   ///< evaluated from observations (A) or otherwise (B)
  std::string unit;  ///< of the input
  double input_u = std::numeric_limits<double>::quiet_NaN();  ///< its standard uncertainty
  /// d BRDF / d input, 1/(sr unit): NaN where several inputs stand behind the name.
  double sensitivity = std::numeric_limits<double>::quiet_NaN();
  double u_per_sr = 0;                                   ///< contribution, size of it
  double dof = std::numeric_limits<double>::infinity();  ///< degrees of freedom
};

struct PointBudget {
  std::size_t point = 0;  ///< row of the table
  std::vector<Contribution> contributions;
  double combined_u = 0;                                           ///< 1/sr
  double effective_dof = std::numeric_limits<double>::infinity();  ///< Welch–Satterthwaite
  double coverage_factor = 1.96;                                   ///< for 95 %
  double expanded_u = 0;                                           ///< 1/sr
};

/// Budget of every point of a reduction. Contributions are those of `table.factors` by name, the
/// columns of one quantity together ("instrument function 532 nm 3" -> "instrument function"), and
/// the noise. The combined variance is exactly that of the table.
std::vector<PointBudget> budget_of(const Reduction& reduction, const Calibration& calibration);

/// Name under which a factor stands in the budget.
std::string contribution_name(const std::string& factor);

/// Two-sided 95 % quantile of Student's t; infinite degrees of freedom: the normal one.
double coverage_factor_95(double dof);

/// Sizes of one contribution over all used points that have it; a short table has them largest
/// first.
struct BudgetShare {
  std::string name;
  char type;
  double median_relative_u;  ///< of u/BRDF
  double high_relative_u;    ///< 95 % of the points have less
};
std::vector<BudgetShare> budget_shares(const Reduction& reduction,
                                       const std::vector<PointBudget>& budget);

/// Writes one line a contribution and point, with a line `combined` a point, as CSV; or, for a name
/// that ends in .json, one object a point. `monte_carlo_u` adds what draws gave; empty = none.
void write_budget(const std::filesystem::path& path, const Reduction& reduction,
                  const std::vector<PointBudget>& budget,
                  const std::vector<double>& monte_carlo_u = {});

}  // namespace umov::calibrate
