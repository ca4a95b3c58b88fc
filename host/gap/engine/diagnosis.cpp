#include "host/gap/engine/diagnosis.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <random>
#include <set>

#include "host/gap/engine/folds.hpp"
#include "host/gap/engine/hollow.hpp"
#include "host/gap/engine/shares.hpp"
#include "host/parallel/for_each_index.hpp"

namespace umov::gap {
namespace {

constexpr std::size_t most_rivals = 5;  // of one cause
/// Iterations of a rival's refit before it is judged, and the rise of χ² within which it goes on.
constexpr int first_look = 4;
constexpr double far_off = 150;
/// Iterations of a fit of some of the named effects: shares are no better than a hundredth.
constexpr int for_a_share = 6;

/// χ² of withheld rows, fold by fold.
std::vector<double> held_out_by_fold(const ForwardModel& model, const Refit& fit,
                                     const Whitening& whitening, const std::vector<int>& fold) {
  return LinearView(model, fit, whitening, fold, false).held_out_by_fold();
}

double sum(const std::vector<double>& values) {
  double total = 0;
  for (const double v : values) total += v;
  return total;
}

/// Sets that share a member become one.
std::vector<std::vector<std::string>> merged(std::vector<std::set<std::string>> sets) {
  for (bool again = true; again;) {
    again = false;
    for (std::size_t a = 0; a < sets.size() && !again; ++a) {
      for (std::size_t b = a + 1; b < sets.size() && !again; ++b) {
        const bool touch = std::any_of(sets[a].begin(), sets[a].end(),
                                       [&](const auto& s) { return sets[b].contains(s); });
        if (!touch) continue;
        sets[a].insert(sets[b].begin(), sets[b].end());
        sets.erase(sets.begin() + static_cast<std::ptrdiff_t>(b));
        again = true;
      }
    }
  }
  std::vector<std::vector<std::string>> result;
  for (const auto& s : sets)
    if (s.size() > 1) result.emplace_back(s.begin(), s.end());
  return result;
}

class Diagnoser {
 public:
  Diagnoser(const ForwardModel& model, const DiagnoseOptions& options)
      : model_(model), options_(options) {}

  Diagnosis run() {
    d_.search = search(model_, options_.search);
    d_.base_whitening = d_.search.whitening;
    final_ = confirmed(d_.search.hypotheses.front(), d_.search.hypotheses[d_.search.base],
                       *d_.search.whitening);
    ambiguity(*d_.search.whitening);
    probabilities();
    scatter();
    const Refit base = d_.search.hypotheses[d_.search.base].refit;
    const Whitening& whitening = *d_.search.whitening;
    d_.where = find_where(model_, base, options_.draws, options_.search.seed + 1);
    const Refit& after = final_.refit;
    if (!scatter_) look_at_rest(after, whitening);
    gaps(base, after, whitening);
    causes(base, after, whitening);
    verdict();
    admit_the_unknown();
    const Eigen::VectorXd errors = standard_errors(after.precision);
    for (std::size_t i = 0; i < model_.base().size(); ++i)
      d_.base.push_back(named_value(model_.base()[i], after.explanation.base[i],
                                    errors[static_cast<Eigen::Index>(i)]));
    d_.best = after;
    return std::move(d_);
  }

 private:
  /// The best hypothesis as far as evidence and withheld rows agree: effects without which withheld
  /// rows are foretold as well leave it, one at a time.
  Hypothesis confirmed(Hypothesis best, const Hypothesis& base, const Whitening& whitening) const {
    if (base.refit.chi2 - best.refit.chi2 <= d_.search.null_99) return base;
    const auto withheld = [&](const Refit& fit) {
      return sum(held_out_by_fold(model_, fit, whitening, d_.search.fold));
    };
    best.held_out_chi2 = withheld(best.refit);
    while (!best.refit.explanation.effects.empty()) {
      std::vector<std::size_t> effects;
      for (std::size_t k = 0; k < best.refit.explanation.effects.size(); ++k) {
        const std::size_t e = best.refit.explanation.effects[k];
        if (!carries(e) && worth_by_curvature(model_, best.refit, k) < beyond_doubt)
          effects.push_back(e);
      }
      if (effects.empty()) break;
      std::vector<Hypothesis> smaller(effects.size());
      for_each_index(effects.size(), options_.search.threads, [&](std::size_t i) {
        smaller[i].refit = refit(model_, without_effect(best.refit.explanation, effects[i]),
                                 whitening, 15, &best.refit);
        smaller[i].held_out_chi2 = withheld(smaller[i].refit);
      });
      const auto least = std::min_element(
          smaller.begin(), smaller.end(),
          [](const auto& a, const auto& b) { return a.held_out_chi2 < b.held_out_chi2; });
      if (least->held_out_chi2 > best.held_out_chi2) break;
      best = std::move(*least);
      best.refit = refit(model_, best.refit.explanation, whitening);
      best.ln_evidence =
          log_evidence(model_, best.refit) +
          log_prior_odds(model_) * static_cast<double>(best.refit.explanation.effects.size());
    }
    return best;
  }

  /// Part of the structure without which nothing else could be seen.
  bool carries(std::size_t effect) const {
    const auto& structure = d_.search.structure;
    return std::find(structure.begin(), structure.end(), effect) != structure.end();
  }

  /// What an explanation leaves: where, and whether it varies with something.
  void look_at_rest(const Refit& fit, const Whitening& whitening) {
    d_.unexplained = find_where(model_, fit, options_.draws, options_.search.seed + 2);
    d_.variation =
        strongest_variation(model_, fit, whitening, d_.search.null_99, options_.search.threads);
    if (Variation slow = slow_wander(model_, fit, whitening, d_.search.noise_scale);
        slow.p_global < d_.variation.p_global)
      d_.variation = std::move(slow);
    d_.unexplained_p =
        std::min({1.0, d_.unexplained.p_global, d_.variation.p_global / options_.varying_share});
  }

  /// Whether what scatters beyond the known noise is an effect's. If so, the noise is parted into
  /// what is the effect's and what is not: the base is judged without the former.
  void scatter() {
    const auto& effects = model_.effects();
    const auto kind =
        std::find_if(effects.begin(), effects.end(), [](const Effect& e) { return e.scatter; });
    const RelativeNoise& learned = d_.search.relative_noise;
    if (kind == effects.end() || !(std::hypot(learned.white, learned.pattern) > 0)) return;
    // With about the right weights: else what scatters most would lead the fit.
    const Whitening plain(model_.noise(final_.refit.mean),
                          {std::hypot(learned.white, learned.pattern), 0, 0},
                          d_.search.noise_scale);
    const LinearView view(model_, refit(model_, final_.refit.explanation, plain, 3), plain,
                          d_.search.fold, true, options_.search.threads);
    const LinearView::Left left = view.left_by_everything();
    const Leftover leftover{left.residual.cwiseProduct(plain.white_sigma()), left.kept,
                            d_.search.noise_scale};
    d_.excess = weigh_excess(
        model_, *kind, plain.shape(), leftover,
        learn_relative_noise(plain.shape(), leftover.residual, leftover.kept, leftover.noise_scale),
        log_prior_odds(model_));
    const ExcessVariance& found = *d_.excess;
    if (!found.confirmed()) return;
    const auto number = static_cast<std::size_t>(kind - effects.begin());
    const auto& without = options_.search.without;
    const bool excluded = std::find(without.begin(), without.end(), number) != without.end();
    // Fresh noise is no effect: it is in the noise as learned.
    const bool alone = excluded || !found.ambiguous(options_.ambiguous);
    const bool seen = (alone ? found.probability : found.joint_probability()) >= options_.named;
    if (!seen) return;
    RelativeNoise rest = found.with;
    rest.pattern = 0;
    const auto whitened = [&](const RelativeNoise& noise) {
      return std::make_shared<const Whitening>(plain.shape(), noise, d_.search.noise_scale);
    };
    if (!excluded) {
      // Scatter of a model that misses the mean is none of the sample's.
      const auto noise = whitened(found.with);
      Refit settled = refit(model_, final_.refit.explanation, *noise);
      look_at_rest(settled, *noise);
      if (significant_rest()) return;
      scatter_ = number;
      d_.search.whitening = noise;
      final_.refit = std::move(settled);
    }
    d_.base_whitening = whitened(rest);
    if (excluded) {
      d_.search.whitening = d_.base_whitening;
      final_.refit = refit(model_, final_.refit.explanation, *d_.base_whitening);
    }
    d_.search.relative_noise = excluded ? rest : found.with;
    // What is expected of the base model is judged by what the sample is not said to scatter.
    Refit& base = d_.search.hypotheses[d_.search.base].refit;
    base = refit(model_, base.explanation, *d_.base_whitening);
    if (excluded) return;
    for (auto& [name, p] : d_.probabilities)
      if (name == kind->name) p = found.probability;
    d_.probabilities.emplace_back(unseen_noise, found.fresh_probability);
    std::stable_sort(d_.probabilities.begin(), d_.probabilities.end(),
                     [](const auto& a, const auto& b) { return a.second > b.second; });
    if (found.ambiguous(options_.ambiguous))
      d_.ambiguity_sets.push_back({kind->name, unseen_noise});
  }

  /// Over the hypotheses of the search and the rivals that were tried after it.
  void probabilities() {
    std::vector<Hypothesis>& all = d_.search.hypotheses;
    double best = -1e300, total = 0;
    for (const Hypothesis& h : all) best = std::max(best, h.ln_evidence);
    for (Hypothesis& h : all) total += h.probability = std::exp(h.ln_evidence - best);
    std::map<std::string, double> by_name;
    for (const Effect& e : model_.effects()) by_name[e.name] = 0;
    for (Hypothesis& h : all) {
      h.probability /= total;
      std::set<std::string> names;
      for (const std::size_t e : h.refit.explanation.effects)
        names.insert(model_.effects()[e].name);
      for (const std::string& name : names) by_name[name] += h.probability;
    }
    for (auto& [name, p] : by_name) d_.probabilities.emplace_back(name, std::min(1.0, p));
    std::stable_sort(d_.probabilities.begin(), d_.probabilities.end(),
                     [](const auto& a, const auto& b) { return a.second > b.second; });
  }

  /// Probabilities so far are those among the explanations that were tried.
  void admit_the_unknown() {
    const double known = 1 - options_.outside_catalogue;
    for (Cause& c : d_.causes) c.probability *= known;
    for (auto& [name, p] : d_.probabilities) p *= known;
  }

  /// Takes a hypothesis into the search's list unless its set of effects is there.
  void keep(Hypothesis hypothesis) {
    for (const Hypothesis& h : d_.search.hypotheses)
      if (h.refit.explanation.effects == hypothesis.refit.explanation.effects) return;
    d_.search.hypotheses.push_back(std::move(hypothesis));
  }

  double probability_of(const std::string& name) const {
    for (const auto& [n, p] : d_.probabilities)
      if (n == name) return p;
    return 0;
  }

  GapSize size_of(double held_out, const Refit& fit, const Whitening& whitening) const {
    const auto n = static_cast<double>(fit.residual.size());
    GapSize gap{held_out / n - 1, 0};
    const double sharpness = fit.mean.cwiseQuotient(whitening.white_sigma()).squaredNorm() / n;
    gap.percent = 100 * std::sqrt(std::max(0.0, gap.g2) / std::max(sharpness, 1e-300));
    return gap;
  }

  void gaps(const Refit& base, const Refit& after, const Whitening& whitening) {
    const auto& fold = d_.search.fold;
    const std::vector<double> b = held_out_by_fold(model_, base, *d_.base_whitening, fold);
    const std::vector<double> a = held_out_by_fold(model_, after, whitening, fold);
    const LinearView view(model_, after, whitening, fold, false);
    const double floor = view.held_out_floor(options_.draws, options_.search.seed + 3);
    d_.before = size_of(sum(b), base, *d_.base_whitening);
    d_.after = size_of(sum(a), after, whitening);
    d_.floor = size_of(floor, after, whitening);
    const auto fraction = [&](double before, double left) {
      const double whole = before - floor;
      return whole > 0 ? (before - left) / whole : 0.0;
    };
    d_.closed_fraction.value = fraction(sum(b), sum(a));
    std::mt19937_64 random(options_.search.seed + 4);
    std::vector<double> drawn;
    for (int i = 0; i < options_.draws; ++i) {
      double before = 0, left = 0;
      for (std::size_t k = 0; k < b.size(); ++k) {
        const std::size_t pick = random() % b.size();
        before += b[pick];
        left += a[pick];
      }
      drawn.push_back(fraction(before, left));
    }
    std::sort(drawn.begin(), drawn.end());
    d_.closed_fraction.lo = drawn[drawn.size() / 40];
    d_.closed_fraction.hi = drawn[drawn.size() - 1 - drawn.size() / 40];
    d_.unexplained_g2 = std::max(0.0, d_.after.g2 - d_.floor.g2);
  }

  void causes(const Refit& base, const Refit& after, const Whitening& whitening) {
    const auto& chosen = after.explanation.effects;
    if (chosen.empty() && !scatter_) {
      d_.ambiguity_sets.clear();
      return;
    }
    // What every subset of the small effects closes on withheld rows. Structure comes before them:
    // without it nothing they do can be seen.
    std::vector<std::size_t> small;
    for (const std::size_t e : chosen)
      if (!model_.effects()[e].structural) small.push_back(e);
    const std::size_t n = chosen.size();
    // The effect that scatters is the last of them.
    const std::size_t parts = small.size() + (scatter_ ? 1 : 0);
    const double nothing = sum(held_out_by_fold(model_, base, *d_.base_whitening, d_.search.fold));
    std::optional<Refit> unscattered;
    if (scatter_) unscattered = refit(model_, after.explanation, *d_.base_whitening, 15);
    const auto closed_by = [&](Subset subset) {
      Explanation part = after.explanation;
      for (std::size_t i = 0; i < small.size(); ++i)
        if (!((subset >> i) & 1U)) part = without_effect(part, small[i]);
      const bool bare = scatter_ && !((subset >> small.size()) & 1U);
      const Whitening& noise = bare ? *d_.base_whitening : whitening;
      const Refit& near = bare ? *unscattered : after;
      const Refit fit =
          part.effects == chosen ? near : refit(model_, part, noise, for_a_share, &near);
      return nothing - sum(held_out_by_fold(model_, fit, noise, d_.search.fold));
    };
    const std::vector<double> of_small = shapley_values(parts, closed_by, options_.search.threads);
    const double by_structure = small.size() == n ? 0.0 : closed_by(0);
    const double whole = std::max(by_structure + sum(of_small), 1e-300);
    const double rest = d_.unexplained_g2 * static_cast<double>(after.residual.size());
    std::vector<double> share(n, 0.0);
    for (std::size_t k = 0, next_small = 0; k < n; ++k) {
      share[k] = model_.effects()[chosen[k]].structural
                     ? by_structure / static_cast<double>(n - small.size())
                     : of_small[next_small++];
    }
    std::set<std::size_t> hollow;
    if (varies(d_, options_))
      hollow = not_needed_beside(model_, after, d_.variation.signature, options_.needed);
    for (std::size_t k = 0; k < n; ++k) {
      const Effect& effect = model_.effects()[chosen[k]];
      // What stays unexplained could be taken for an effect as large: such a one is not named.
      const bool outweighed = significant_rest() && !effect.structural && share[k] < rest;
      if (joint_probability(effect.name) >= options_.named && !outweighed &&
          !hollow.contains(chosen[k]))
        d_.causes.push_back({effect.name, effect.family, probability_of(effect.name),
                             share[k] / whole, effect_parameters(model_, after, k, whitening)});
    }
    if (scatter_ && !significant_rest()) {
      const ExcessVariance& found = *d_.excess;
      const Effect& effect = model_.effects()[*scatter_];
      const Parameter& size = effect.parameters.front();
      d_.causes.push_back({effect.name,
                           effect.family,
                           found.probability,
                           of_small.back() / whole,
                           {{size.name, size.unit, {found.size, found.lo, found.hi}}}});
    }
    std::erase_if(d_.ambiguity_sets, [&](const std::vector<std::string>& set) {
      return std::none_of(d_.causes.begin(), d_.causes.end(), [&](const Cause& c) {
        return std::find(set.begin(), set.end(), c.effect) != set.end();
      });
    });
    std::stable_sort(d_.causes.begin(), d_.causes.end(),
                     [](const Cause& a, const Cause& b) { return a.share > b.share; });
  }

  /// Each cause on trial against every other effect in its place.
  void ambiguity(const Whitening& whitening) {
    const Hypothesis best = final_;
    keep(best);
    std::vector<std::set<std::string>> sets;
    Hypothesis better = best;
    std::string out, in;  // what `better` takes out and in
    const double ln_odds = log_prior_odds(model_);
    std::vector<std::size_t> members;
    for (const std::size_t e : best.refit.explanation.effects)
      if (!carries(e)) members.push_back(e);
    // What effects look like hardly depends on the cause that is on trial.
    std::optional<LinearView> near;
    if (members.size() > 1)
      near.emplace(model_, best.refit, whitening, d_.search.fold, true, options_.search.threads);
    for (const std::size_t member : members) {
      std::set<std::string> set{model_.effects()[member].name};
      // Where the cause is taken away and nothing else has moved yet: a rival starts from what it
      // would have to stand in for, with all other parameters where they belong.
      const Refit smaller =
          refit(model_, without_effect(best.refit.explanation, member), whitening, 0, &best.refit);
      const LinearView view(model_, smaller, whitening, d_.search.fold, true,
                            options_.search.threads, near ? &*near : nullptr);
      // The linear view overrates what a rival could do as often as not: half of what it sees of
      // the cause itself will do for a trial.
      double own = 0;
      for (std::size_t c = 0; c < view.candidates().size(); ++c) {
        const std::size_t one[] = {c};
        if (view.candidates()[c].effect == member) own = std::max(own, view.fit(one).gain);
      }
      const double needed = 0.5 * own;
      std::vector<std::pair<double, std::size_t>> candidates;
      for (std::size_t c = 0; c < view.candidates().size(); ++c) {
        const std::size_t effect = view.candidates()[c].effect;
        const auto& excluded = options_.search.without;
        if (effect == member ||
            std::find(excluded.begin(), excluded.end(), effect) != excluded.end())
          continue;
        const std::size_t one[] = {c};
        const LinearFit alone = view.fit(one);
        if (alone.gain > needed) candidates.emplace_back(-alone.ln_evidence, c);
      }
      std::sort(candidates.begin(), candidates.end());
      std::vector<std::size_t> rivals;
      std::set<std::size_t> tried;
      for (const auto& [cost, c] : candidates)
        if (tried.size() < most_rivals && tried.insert(view.candidates()[c].effect).second)
          rivals.push_back(c);
      std::vector<Hypothesis> trials(rivals.size());
      for_each_index(rivals.size(), options_.search.threads, [&](std::size_t i) {
        const std::size_t one[] = {rivals[i]};
        Hypothesis& h = trials[i];
        const Explanation start =
            with_effect(smaller.explanation, view.candidates()[rivals[i]].effect,
                        view.alpha(rivals[i], view.fit(one).coefficient));
        h.refit = refit(model_, start, whitening, first_look, &best.refit);
        if (h.refit.chi2 - best.refit.chi2 < std::max(far_off, 0.3 * own))
          h.refit = refit(model_, h.refit.explanation, whitening, 15, &best.refit);
        h.ln_evidence = log_evidence(model_, h.refit) +
                        ln_odds * static_cast<double>(h.refit.explanation.effects.size());
      });
      for (std::size_t i = 0; i < rivals.size(); ++i) {
        if (2 * (best.ln_evidence - trials[i].ln_evidence) < options_.ambiguous) {
          set.insert(model_.effects()[view.candidates()[rivals[i]].effect].name);
          d_.rivals.push_back({model_.effects()[member].name,
                               model_.effects()[view.candidates()[rivals[i]].effect].name,
                               best.refit, trials[i].refit});
        }
        if (trials[i].ln_evidence > better.ln_evidence) {
          better = trials[i];
          out = model_.effects()[member].name;
          in = model_.effects()[view.candidates()[rivals[i]].effect].name;
        }
        keep(std::move(trials[i]));
      }
      sets.push_back(std::move(set));
    }
    d_.ambiguity_sets = merged(std::move(sets));
    if (better.ln_evidence > best.ln_evidence) change_to(std::move(better), out, in, whitening);
  }

  /// A rival turned out to be the better explanation: `in` in place of `out`.
  void change_to(Hypothesis better, const std::string& out, const std::string& in,
                 const Whitening& whitening) {
    const Refit before = std::move(final_.refit);
    better.refit = refit(model_, better.refit.explanation, whitening);
    final_ = std::move(better);
    for (Diagnosis::Rival& r : d_.rivals) {
      if (r.effect != out) continue;
      if (r.rival_effect == in)
        r = {in, out, final_.refit, before};
      else
        r = {in, r.rival_effect, final_.refit, std::move(r.rival)};
    }
  }

  bool significant_rest() const { return d_.unexplained_p < options_.significance; }

  /// Of a cause and what cannot be told from it.
  double joint_probability(const std::string& name) const {
    for (const auto& set : d_.ambiguity_sets) {
      if (std::find(set.begin(), set.end(), name) == set.end()) continue;
      double sum_of_set = 0;
      for (const std::string& member : set) sum_of_set += probability_of(member);
      return std::min(1.0, sum_of_set);
    }
    return probability_of(name);
  }

  void verdict() {
    const bool left = significant_rest();
    if (final_.refit.explanation.effects.empty() && d_.causes.empty()) {
      d_.verdict = left ? Verdict::unexplained : Verdict::none_needed;
    } else if (d_.causes.empty()) {
      d_.verdict = Verdict::unexplained;
    } else {
      d_.verdict = left ? Verdict::explained_in_part : Verdict::explained;
    }
  }

  const ForwardModel& model_;
  const DiagnoseOptions& options_;
  Hypothesis final_;
  /// The effect that scatters, where there is one in the explanation.
  std::optional<std::size_t> scatter_;
  Diagnosis d_;
};

}  // namespace

const char* to_string(Verdict verdict) {
  switch (verdict) {
    case Verdict::none_needed:
      return "none_needed";
    case Verdict::explained:
      return "explained";
    case Verdict::explained_in_part:
      return "explained_in_part";
    case Verdict::unexplained:
      return "unexplained";
  }
  return "";
}

bool varies(const Diagnosis& diagnosis, const DiagnoseOptions& options) {
  return diagnosis.variation.p_global < options.varying_share * options.significance;
}

Diagnosis diagnose(const ForwardModel& model, const DiagnoseOptions& options) {
  return Diagnoser(model, options).run();
}

}  // namespace umov::gap
