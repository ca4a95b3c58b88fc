// Uncertainty budget, Monte Carlo check and reciprocity of a reduction for the terminal and --json.
#pragma once

#include <optional>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "host/calibrate/budget.hpp"
#include "host/calibrate/monte_carlo.hpp"
#include "host/calibrate/reciprocity.hpp"

namespace umov::cli {

/// What `umov reduce` can say of the quality of its points.
struct PointQuality {
  std::vector<calibrate::PointBudget> budget;  ///< empty: not asked for
  std::optional<calibrate::MonteCarlo> draws;
  calibrate::MonteCarloAgreement agreement;         ///< where there are draws
  std::vector<calibrate::Reciprocity> reciprocity;  ///< empty: no pairs
};

void print_quality(const PointQuality& quality, const calibrate::Reduction& reduction);
/// Adds the keys `budget`, `monte_carlo` and `reciprocity` where there is something to say.
void add_quality(const PointQuality& quality, const calibrate::Reduction& reduction,
                 nlohmann::json& out);

}  // namespace umov::cli
