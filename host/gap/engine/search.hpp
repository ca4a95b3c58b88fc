// Which set of effects explains a measurement: a beam search over sets on the linear view, followed
// by full refits of the best.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "host/gap/engine/forward_model.hpp"
#include "host/gap/engine/linear_view.hpp"
#include "host/gap/engine/refit.hpp"

namespace umov::gap {

struct SearchOptions {
  std::size_t max_effects = 8;    ///< besides the structure taken in before
  std::size_t max_structure = 6;  ///< structural ones taken in before the others
  std::size_t beam = 24;          ///< sets kept at each size
  std::size_t refits = 12;        ///< best sets that are refitted in full
  int folds = 10;
  std::uint64_t seed = 1;
  /// Effects that must not be used (numbers).
  std::vector<std::size_t> without;
  int threads = 0;  ///< 0: all cores; the result does not depend on it
  std::function<void(double, const char*)> progress;
};

/// A set of effects at its best values.
struct Hypothesis {
  Refit refit;
  double ln_evidence = 0;    ///< Laplace, priors of effects and of their number included
  double held_out_chi2 = 0;  ///< of withheld rows
  double probability = 0;    ///< among the hypotheses kept
};

struct SearchResult {
  /// The base model alone is always among them.
  std::vector<Hypothesis> hypotheses;
  double noise_scale = 1;        ///< common factor of the white noise; 1 where it is known
  RelativeNoise relative_noise;  ///< as learned
  /// Of all hypotheses; where a diagnosis names an effect that scatters, of its best fit, and the
  /// base's is Diagnosis::base_whitening.
  std::shared_ptr<const Whitening> whitening;
  std::vector<int> fold;
  /// Structural effects taken in before the others that took away most of the misfit of their time.
  std::vector<std::size_t> structure;
  /// Δχ² that the best single effect would reach by chance in 1 % of measurements of noise alone.
  double null_99 = 0;
  std::size_t base = 0;  ///< place of the base model in `hypotheses`
};

/// Rise of χ² by the curvature above which an effect need not be left out to see that it is there.
inline constexpr double beyond_doubt = 300;

/// The same options with structural effects left out.
SearchOptions without_structure(const ForwardModel& model, SearchOptions options);
/// ln of the odds of one effect before any data: one is expected in all.
double log_prior_odds(const ForwardModel& model);
/// ln of the evidence of an explanation by Laplace's method, without the prior of its effects'
/// presence. `inflation`: factor of the noise's variance; the curvature is left as it is.
double log_evidence(const ForwardModel& model, const Refit& fit, double inflation = 1);

SearchResult search(const ForwardModel& model, const SearchOptions& options);

}  // namespace umov::gap
