// Sets of a linear view's candidates by evidence: a beam that grows, exchanges and shrinks them.
#pragma once

#include <cstddef>
#include <map>
#include <set>
#include <vector>

#include "host/gap/engine/linear_view.hpp"
#include "host/gap/engine/search.hpp"

namespace umov::gap {

/// Numbers of a view's candidates, ascending.
using CandidateSet = std::vector<std::size_t>;

struct ScoredSet {
  CandidateSet set;
  double score;  ///< ln of the evidence, the prior of the effects' presence included
};

/// Sets of candidates by evidence, grown, exchanged and shrunk from the empty one.
class Beam {
 public:
  /// `ln_odds` of one effect's presence; `effects_already` count towards the most that are allowed.
  Beam(const LinearView& view, const SearchOptions& options, double ln_odds,
       std::size_t effects_already);

  /// All sets that were looked at, the best first.
  std::vector<ScoredSet> run();

 private:
  double score(const CandidateSet& set);
  void grow(const CandidateSet& set, std::set<CandidateSet>& into) const;
  std::vector<ScoredSet> best_of(const std::set<CandidateSet>& sets);

  const LinearView& view_;
  const SearchOptions& options_;
  double ln_odds_;
  std::vector<std::size_t> usable_;
  std::size_t largest_ = 0;
  std::map<CandidateSet, double> known_;
};

/// A set of effects and the ways it was looked at: the same effects from other probes.
struct Proposal {
  std::vector<std::size_t> effects;  ///< ascending
  std::vector<ScoredSet> starts;     ///< the best first
};

/// The `most` best sets of effects with up to `starts` starts each, from a beam's sets, and the
/// best of each size that is not among them: large sets stand or fall with each of their members.
/// The empty set is none.
std::vector<Proposal> proposals(const LinearView& view, const std::vector<ScoredSet>& scored,
                                std::size_t most, std::size_t starts);

/// The explanation with a set of a view's candidates at their best coefficients.
Explanation with_candidates(Explanation explanation, const LinearView& view,
                            const CandidateSet& set);

}  // namespace umov::gap
