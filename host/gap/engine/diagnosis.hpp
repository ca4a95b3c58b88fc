// The answer: where a simulation misses a measurement, which effects cause it, how far the gap
// closes, what cannot be told.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/gap/engine/excess_variance.hpp"
#include "host/gap/engine/forward_model.hpp"
#include "host/gap/engine/intervals.hpp"
#include "host/gap/engine/search.hpp"
#include "host/gap/engine/variation.hpp"
#include "host/gap/engine/where.hpp"

namespace umov::gap {

struct Cause {
  std::string effect, family;
  double probability = 0;
  double share = 0;  ///< of the gap closed, Shapley on withheld rows
  std::vector<NamedValue> parameters;
};

struct GapSize {
  double g2 = 0;       ///< mean squared whitened residual of withheld rows, less one
  double percent = 0;  ///< the even relative deviation of the signal that would show as much
};

/// 95 % intervals of a gap's size.
struct GapInterval {
  Interval g2, percent;
};

struct GapBounds {
  GapInterval before, after, floor;
};

enum class Verdict { none_needed, explained, explained_in_part, unexplained };
const char* to_string(Verdict verdict);

/// A further measurement that would tell rivals apart.
struct FurtherScan {
  std::string menu;                                 ///< its identifier
  std::vector<std::vector<std::string>> separates;  ///< pairs of effects or sums of effects
  double expected_separation = 0;  ///< least whitened distance of these pairs once it is taken
  double minutes = 0;
};

struct Diagnosis {
  Verdict verdict = Verdict::none_needed;
  GapSize before, after, floor;
  Interval closed_fraction;
  std::optional<GapBounds> bounds;  ///< where they were asked for (gap_bounds)
  Where where;                      ///< of the base model's residual
  Where unexplained;                ///< of what the causes leave
  double unexplained_g2 = 0;        ///< beyond the floor
  Variation variation;              ///< the same read as something known that varies
  double unexplained_p = 1;         ///< of both, that noise alone leaves as much
  std::vector<Cause> causes;        ///< largest share first
  /// Effects that this measurement cannot tell apart; each set holds a cause and its rivals.
  std::vector<std::vector<std::string>> ambiguity_sets;
  /// Probability of every effect in the catalogue, by name; families of one name are summed.
  std::vector<std::pair<std::string, double>> probabilities;
  std::vector<NamedValue> base;
  /// Explanations that are as good as the one named, each with what it puts in whose place.
  struct Rival {
    std::string effect, rival_effect;
    Refit best, rival;
  };
  std::vector<Rival> rivals;
  std::vector<FurtherScan> next_scan;  ///< best per minute first; what an adapter found
  /// What was found of the catalogue's effect that only scatters, where there is anything.
  std::optional<ExcessVariance> excess;
  /// The whitening of the base model's residual: without the scatter that a cause explains. Where
  /// there is no such cause that of the search.
  std::shared_ptr<const Whitening> base_whitening;
  Refit best;  ///< the base with the causes, whitened as the search says
  SearchResult search;
};

/// Noise that no catalogue lists: as large as an effect of the kind `scatter`, but new in every
/// observation. Its rival where no place is measured twice.
inline constexpr const char* unseen_noise = "unseen_noise";

struct DiagnoseOptions {
  SearchOptions search;
  int draws = 400;       ///< of noise alone, for significances
  double named = 0.5;    ///< least probability of a cause
  double ambiguous = 6;  ///< rivals within this of twice the log evidence
  double significance = 0.01;
  /// Share of `significance` that signs of a variation may use up. Small: they are looked for
  /// among thousands, and rest on signatures that are right to a few per cent only.
  double varying_share = 0.2;
  /// Part of all that looks like an effect of the catalogue that is something else, which no
  /// catalogue has: probabilities are told less by it.
  double outside_catalogue = 0.04;
  /// Least Δχ² of a cause beside a variation that was found.
  double needed = 10;
};

/// Is the variation that was found more than chance?
bool varies(const Diagnosis& diagnosis, const DiagnoseOptions& options = {});

Diagnosis diagnose(const ForwardModel& model, const DiagnoseOptions& options = {});

}  // namespace umov::gap
