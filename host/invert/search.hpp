// From many starts to one optimum.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "host/invert/minimise.hpp"

namespace umov::invert {

struct Found {
  Solution solution;
  double scale = 1;          ///< of the residuals, 1 where the noise explains them
  std::size_t starts = 0;    ///< tried
  std::size_t agreeing = 0;  ///< of these, ended at the best objective within 1 in 1000
  int start_iterations = 0;  ///< of the winner, on thinned points
  std::vector<std::pair<std::string, double>> phase_seconds;
};

/// Many starts on thinned points, a line search along every shape parameter from the best of them,
/// the best different ones on all points, and, at the optimum, other shapes for terms that are
/// idle there. Does not depend on the number of threads.
Found search(const Layout& layout, const Observations& data, const Priors& priors,
             const Options& options);

/// The thinned points on which starts are tried.
Observations starting_observations(const Observations& data);

}  // namespace umov::invert
