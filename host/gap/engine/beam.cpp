#include "host/gap/engine/beam.hpp"

#include <algorithm>
#include <utility>

namespace umov::gap {
namespace {

bool by_score(const ScoredSet& a, const ScoredSet& b) {
  if (a.score != b.score) return a.score > b.score;
  return a.set < b.set;
}

}  // namespace

Beam::Beam(const LinearView& view, const SearchOptions& options, double ln_odds,
           std::size_t effects_already)
    : view_(view), options_(options), ln_odds_(ln_odds) {
  for (std::size_t c = 0; c < view.candidates().size(); ++c) {
    const std::size_t effect = view.candidates()[c].effect;
    if (std::find(options.without.begin(), options.without.end(), effect) == options.without.end())
      usable_.push_back(c);
  }
  largest_ = options.max_effects > effects_already ? options.max_effects - effects_already : 0;
}

std::vector<ScoredSet> Beam::run() {
  std::vector<ScoredSet> front{{CandidateSet{}, score(CandidateSet{})}};
  double best = front.front().score;
  std::size_t best_size = 0;
  // Two more than the best has may still be worth it together, as one alone is not.
  for (std::size_t size = 1; size <= std::min(largest_, best_size + 2); ++size) {
    std::set<CandidateSet> next;
    for (const ScoredSet& s : front) grow(s.set, next);
    front = best_of(next);
    // Exchanges repair what was chosen before its partners were known.
    for (int pass = 0; pass < 2; ++pass) {
      std::set<CandidateSet> exchanged;
      for (std::size_t k = 0; k < std::min<std::size_t>(front.size(), 6); ++k) {
        exchanged.insert(front[k].set);
        for (std::size_t out = 0; out < front[k].set.size(); ++out) {
          CandidateSet smaller = front[k].set;
          smaller.erase(smaller.begin() + static_cast<std::ptrdiff_t>(out));
          score(smaller);
          grow(smaller, exchanged);
        }
      }
      for (const ScoredSet& s : front) exchanged.insert(s.set);
      front = best_of(exchanged);
    }
    if (!front.empty() && front.front().score > best) {
      best = front.front().score;
      best_size = size;
    }
  }
  std::vector<ScoredSet> all;
  for (const auto& [set, value] : known_) all.push_back({set, value});
  std::sort(all.begin(), all.end(), by_score);
  return all;
}

double Beam::score(const CandidateSet& set) {
  const auto found = known_.find(set);
  if (found != known_.end()) return found->second;
  const double value = view_.fit(set).ln_evidence + ln_odds_ * static_cast<double>(set.size());
  known_.emplace(set, value);
  return value;
}

void Beam::grow(const CandidateSet& set, std::set<CandidateSet>& into) const {
  for (const std::size_t c : usable_) {
    const bool there = std::any_of(set.begin(), set.end(), [&](std::size_t s) {
      return view_.candidates()[s].effect == view_.candidates()[c].effect;
    });
    if (there) continue;
    CandidateSet larger = set;
    larger.insert(std::lower_bound(larger.begin(), larger.end(), c), c);
    into.insert(std::move(larger));
  }
}

std::vector<ScoredSet> Beam::best_of(const std::set<CandidateSet>& sets) {
  std::vector<ScoredSet> scored;
  scored.reserve(sets.size());
  for (const CandidateSet& s : sets) scored.push_back({s, score(s)});
  std::sort(scored.begin(), scored.end(), by_score);
  if (scored.size() > options_.beam) scored.resize(options_.beam);
  return scored;
}

std::vector<Proposal> proposals(const LinearView& view, const std::vector<ScoredSet>& scored,
                                std::size_t most, std::size_t starts) {
  std::vector<Proposal> found;
  std::map<std::vector<std::size_t>, std::size_t> place;
  std::set<std::size_t> sizes;
  std::size_t larges = 0;
  for (const ScoredSet& s : scored) {
    if (s.set.empty()) continue;
    std::vector<std::size_t> effects;
    for (const std::size_t c : s.set) effects.push_back(view.candidates()[c].effect);
    std::sort(effects.begin(), effects.end());
    const auto there = place.find(effects);
    if (there != place.end()) {
      std::vector<ScoredSet>& own = found[there->second].starts;
      if (own.size() < starts) own.push_back(s);
      continue;
    }
    // Large sets are variants of one: what they differ in shows in the next view.
    constexpr std::size_t large = 4, most_large = 3;
    const bool is_large = effects.size() >= large;
    const bool room = found.size() < most && (!is_large || larges < most_large);
    if (room || !sizes.contains(effects.size())) {
      sizes.insert(effects.size());
      if (is_large) ++larges;
      place.emplace(effects, found.size());
      found.push_back({std::move(effects), {s}});
    }
  }
  return found;
}

Explanation with_candidates(Explanation explanation, const LinearView& view,
                            const CandidateSet& set) {
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
