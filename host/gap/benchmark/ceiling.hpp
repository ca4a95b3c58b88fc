// How often a single effect could be named at best: with everything known but which effect it is.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "host/gap/engine/linear_view.hpp"

namespace umov::gap {

struct NamingRates {
  int drawn = 0, named = 0, in_set = 0;
  long set_size = 0;  ///< summed
  /// How often the second was named instead of the first.
  std::map<std::pair<std::string, std::string>, int> taken_for;

  NamingRates& operator+=(const NamingRates& other);
};

/// A forward model's neighbourhood as a classifier that knows the signatures of all effects
/// (linear, the base taken out), the noise and the priors of sizes, and that there is one effect
/// and no more. What its rates fall short of one is the measurement's fault, as far as sizes are
/// distributed as those priors say.
class NamingCeiling {
 public:
  /// Effects within this of the best, in twice the logarithm of the evidence, are its set.
  static constexpr double ambiguous = 6;

  /// `at`: a fit of the base alone.
  NamingCeiling(const ForwardModel& model, const Refit& at, const Whitening& whitening,
                int threads = 1);

  /// Every effect that shows (structure and scatter apart) `trials` times with a signature of
  /// length `rho`, standard deviations, after the base was fitted. Does not depend on `threads`.
  NamingRates rates(double rho, int trials, std::uint64_t seed, int threads = 1) const;

 private:
  NamingRates trial(std::size_t effect, double rho, int trials, std::uint64_t seed) const;

  const ForwardModel& model_;
  LinearView view_;
  std::vector<std::size_t> shown_;  ///< candidates that can be seen
  Eigen::MatrixXd root_;
};

}  // namespace umov::gap
