#include "host/gap/engine/structure.hpp"

#include <algorithm>
#include <iterator>
#include <memory>
#include <set>

#include "host/gap/engine/beam.hpp"
#include "host/parallel/for_each_index.hpp"

namespace umov::gap {

Refit with_structure(const ForwardModel& whole, Refit centre, const SearchOptions& options,
                     std::vector<std::size_t>& carrying) {
  const std::unique_ptr<ForwardModel> few = whole.thinned(most_to_find_the_way);
  const ForwardModel& model = few ? *few : whole;
  if (few) {
    Eigen::VectorXd mean;
    model.predict(centre.explanation, mean, nullptr);
    centre = refit(model, centre.explanation, Whitening(model.noise(mean)));
  }
  constexpr double dwarfed = 1.2;  // χ² over the number of observations
  constexpr double several = 3;
  constexpr int first_look = 10;  // iterations for all
  constexpr std::size_t finalists = 4;
  constexpr std::size_t most_sets = 3;    // of effects that are not structural
  constexpr std::size_t most_starts = 2;  // of each, from other probes
  const double ln_odds = log_prior_odds(model);
  SearchOptions small_only = without_structure(model, options);
  small_only.beam = 4;
  small_only.max_effects = std::min<std::size_t>(3, options.max_effects);
  for (std::size_t round = 0; round < options.max_structure; ++round) {
    const Whitening whitening(model.noise(centre.mean));
    centre = refit(model, centre.explanation, whitening);
    const auto n = static_cast<double>(centre.residual.size());
    if (centre.chi2 < dwarfed * n) break;
    std::vector<Explanation> starts;
    for (std::size_t e = 0; e < model.effects().size(); ++e) {
      const Effect& effect = model.effects()[e];
      const auto& there = centre.explanation.effects;
      if (!effect.structural || std::find(there.begin(), there.end(), e) != there.end() ||
          std::find(options.without.begin(), options.without.end(), e) != options.without.end())
        continue;
      // Where probes act together, the refit finds the others from the first.
      for (const auto& group : effect.probes)
        starts.push_back(with_effect(centre.explanation, e, group.front()));
    }
    const std::size_t structural = starts.size();
    {
      const LinearView view(model, centre, whitening, {}, true, options.threads);
      Beam beam(view, small_only, ln_odds, 0);
      for (const Proposal& p : proposals(view, beam.run(), most_sets, most_starts))
        for (const ScoredSet& scored : p.starts)
          starts.push_back(with_candidates(centre.explanation, view, scored.set));
    }
    std::vector<Refit> fits(starts.size());
    const auto cost = [](const Refit& fit) { return fit.chi2 + fit.penalty; };
    for_each_index(starts.size(), options.threads, [&](std::size_t i) {
      fits[i] = refit(model, starts[i], whitening, first_look);
    });
    std::vector<Refit> rivals(
        std::make_move_iterator(fits.begin() + static_cast<std::ptrdiff_t>(structural)),
        std::make_move_iterator(fits.end()));
    fits.resize(structural);
    // The best of each effect go on to the end.
    std::stable_sort(fits.begin(), fits.end(),
                     [&](const Refit& a, const Refit& b) { return cost(a) < cost(b); });
    std::set<std::vector<std::size_t>> sets;
    std::erase_if(fits, [&](const Refit& fit) {
      return sets.size() >= finalists || !sets.insert(fit.explanation.effects).second;
    });
    for_each_index(fits.size(), options.threads, [&](std::size_t i) {
      fits[i] = refit(model, fits[i].explanation, whitening, 25);
    });
    // Noise as large as the best of them leaves: families that differ by less are told apart by how
    // much they had to be bent, not by how well they fit.
    double least = cost(centre);
    for (const Refit& fit : fits) least = std::min(least, cost(fit));
    for (const Refit& fit : rivals) least = std::min(least, cost(fit));
    const double inflation = std::max(1.0, least / n);
    const auto score = [&](const Refit& fit) {
      return log_evidence(model, fit, inflation) +
             ln_odds * static_cast<double>(fit.explanation.effects.size());
    };
    const Refit* best = nullptr;
    double best_score = score(centre);
    for (const Refit& fit : fits) {
      if (score(fit) <= best_score) continue;
      best_score = score(fit);
      best = &fit;
    }
    const bool outdone = std::any_of(rivals.begin(), rivals.end(),
                                     [&](const Refit& fit) { return score(fit) >= best_score; });
    if (best == nullptr || outdone) break;
    if (best->chi2 * several < centre.chi2)
      for (const std::size_t e : best->explanation.effects)
        if (std::find(centre.explanation.effects.begin(), centre.explanation.effects.end(), e) ==
            centre.explanation.effects.end())
          carrying.push_back(e);
    centre = *best;
  }
  if (few == nullptr) return centre;
  Eigen::VectorXd mean;
  whole.predict(centre.explanation, mean, nullptr);
  return refit(whole, centre.explanation, Whitening(whole.noise(mean)));
}

}  // namespace umov::gap
