// Sets of a linear view's candidates by evidence: a beam that grows, exchanges and shrinks them.
#pragma once

#include <algorithm>
#include <cstddef>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "host/gap/engine/linear_view.hpp"
#include "host/gap/engine/search.hpp"

namespace umov::gap {

using Set = std::vector<std::size_t>;  // candidates of a view, ascending

struct Scored {
  Set set;
  double score;
};

inline bool by_score(const Scored& a, const Scored& b) {
  if (a.score != b.score) return a.score > b.score;
  return a.set < b.set;
}

/// Sets of candidates by evidence, grown, exchanged and shrunk from the empty one.
class Beam {
 public:
  Beam(const LinearView& view, const SearchOptions& options, double ln_odds,
       std::size_t effects_already)
      : view_(view), options_(options), ln_odds_(ln_odds) {
    for (std::size_t c = 0; c < view.candidates().size(); ++c) {
      const std::size_t effect = view.candidates()[c].effect;
      if (std::find(options.without.begin(), options.without.end(), effect) ==
          options.without.end())
        usable_.push_back(c);
    }
    largest_ = options.max_effects > effects_already ? options.max_effects - effects_already : 0;
  }

  std::vector<Scored> run() {
    std::vector<Scored> front{{Set{}, score(Set{})}};
    for (std::size_t size = 1; size <= largest_; ++size) {
      std::set<Set> next;
      for (const Scored& s : front) grow(s.set, next);
      front = best_of(next);
      // Exchanges repair what was chosen before its partners were known.
      for (int pass = 0; pass < 2; ++pass) {
        std::set<Set> exchanged;
        for (std::size_t k = 0; k < std::min<std::size_t>(front.size(), 6); ++k) {
          exchanged.insert(front[k].set);
          for (std::size_t out = 0; out < front[k].set.size(); ++out) {
            Set smaller = front[k].set;
            smaller.erase(smaller.begin() + static_cast<std::ptrdiff_t>(out));
            score(smaller);
            grow(smaller, exchanged);
          }
        }
        for (const Scored& s : front) exchanged.insert(s.set);
        front = best_of(exchanged);
      }
    }
    std::vector<Scored> all;
    for (const auto& [set, value] : known_) all.push_back({set, value});
    std::sort(all.begin(), all.end(), by_score);
    return all;
  }

 private:
  double score(const Set& set) {
    const auto found = known_.find(set);
    if (found != known_.end()) return found->second;
    const double value = view_.fit(set).ln_evidence + ln_odds_ * static_cast<double>(set.size());
    known_.emplace(set, value);
    return value;
  }

  void grow(const Set& set, std::set<Set>& into) const {
    for (const std::size_t c : usable_) {
      const bool there = std::any_of(set.begin(), set.end(), [&](std::size_t s) {
        return view_.candidates()[s].effect == view_.candidates()[c].effect;
      });
      if (there) continue;
      Set larger = set;
      larger.insert(std::lower_bound(larger.begin(), larger.end(), c), c);
      into.insert(std::move(larger));
    }
  }

  std::vector<Scored> best_of(const std::set<Set>& sets) {
    std::vector<Scored> scored;
    scored.reserve(sets.size());
    for (const Set& s : sets) scored.push_back({s, score(s)});
    std::sort(scored.begin(), scored.end(), by_score);
    if (scored.size() > options_.beam) scored.resize(options_.beam);
    return scored;
  }

  const LinearView& view_;
  const SearchOptions& options_;
  double ln_odds_;
  std::vector<std::size_t> usable_;
  std::size_t largest_ = 0;
  std::map<Set, double> known_;
};

/// The explanation with a set of a view's candidates at their best coefficients.
inline Explanation with_candidates(Explanation explanation, const LinearView& view,
                                   const Set& set) {
  const LinearFit fit = view.fit(set);
  Eigen::Index first = 0;
  for (const std::size_t c : set) {
    const auto n = static_cast<Eigen::Index>(view.candidates()[c].columns.size());
    explanation = with_effect(explanation, view.candidates()[c].effect,
                              view.alpha(c, fit.coefficient.segment(first, n)));
    first += n;
  }
  return explanation;
}

}  // namespace umov::gap
