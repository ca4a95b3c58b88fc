#include "host/gap/engine/search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <span>

#include <Eigen/Cholesky>

#include "host/gap/engine/beam.hpp"
#include "host/gap/engine/folds.hpp"
#include "host/gap/engine/structure.hpp"
#include "host/parallel/for_each_index.hpp"

namespace umov::gap {
namespace {

/// Of a refit in the search.
constexpr int most_iterations = 8, most_far_iterations = 16;
/// ln of the odds against the best beyond which a hypothesis need not be settled to the last digit.
constexpr double worth_settling = 4;
constexpr std::size_t most_settled = 6;
/// Starts of a single effect (of two or three: two, of more: one), and how far below the linear
/// view's ln of the evidence a refit makes the next worth trying.
constexpr std::size_t most_starts = 4;
constexpr double falls_short = 5;
/// Parameters of a structure beyond which each look around costs a multiple of others.
constexpr std::size_t long_structure = 60;
constexpr double infinity = std::numeric_limits<double>::infinity();

/// The base at the best of its starts.
Refit base_fit(const ForwardModel& whole, int threads) {
  const std::unique_ptr<ForwardModel> few = whole.thinned(most_to_find_the_way);
  const ForwardModel& model = few ? *few : whole;
  const auto fit_from = [&](const Explanation& start) {
    // Weights from the prediction: once from the start's, once from its fit.
    Eigen::VectorXd mean;
    model.predict(start, mean, nullptr);
    const Refit first = refit(model, start, Whitening(model.noise(mean)));
    return refit(model, first.explanation, Whitening(model.noise(first.mean)));
  };
  const std::vector<std::vector<double>> further = model.further_starts();
  std::vector<Refit> fits(1 + further.size());
  for_each_index(fits.size(), threads, [&](std::size_t i) {
    Explanation start = base_explanation(model);
    if (i > 0) start.base = further[i - 1];
    fits[i] = fit_from(start);
  });
  Refit best = std::move(fits.front());
  const Whitening whitening(model.noise(best.mean));
  const auto cost = [&](const Refit& fit) {
    return whitening.apply(model.observations().value - fit.mean).squaredNorm() + fit.penalty;
  };
  double least = cost(best);
  for (std::size_t i = 1; i < fits.size(); ++i) {
    const double value = cost(fits[i]);
    if (value < least - 1e-3) {
      least = value;
      best = std::move(fits[i]);
    }
  }
  if (few == nullptr) return best;
  Eigen::VectorXd mean;
  whole.predict(best.explanation, mean, nullptr);
  return refit(whole, best.explanation, Whitening(whole.noise(mean)));
}

/// A set of effects to be refitted.
struct Task {
  std::vector<std::size_t> effects;
  std::vector<Explanation> starts;
  double foretold;  ///< ln of the evidence
};

/// What a view taken at a hypothesis proposes to add to it.
std::vector<Task> tasks_from(const LinearView& view, const ForwardModel& model,
                             const Hypothesis& at, const SearchOptions& options, double ln_odds) {
  const auto structural = [&](std::size_t e) { return model.effects()[e].structural; };
  const auto& there = at.refit.explanation.effects;
  const auto small = there.size() - static_cast<std::size_t>(
                                        std::count_if(there.begin(), there.end(), structural));
  std::vector<Task> tasks;
  bool more_structure = false;
  const auto propose = [&](const SearchOptions& allowed, std::size_t most) {
    Beam beam(view, allowed, ln_odds, small);
    for (const Proposal& p : proposals(view, beam.run(), most, most_starts)) {
      Task task{{}, {}, at.ln_evidence + p.starts.front().score};
      const std::size_t worth = p.effects.size() == 1 ? most_starts : p.effects.size() < 4 ? 2 : 1;
      const std::size_t used = std::min(p.starts.size(), worth);
      for (const ScoredSet& s : std::span(p.starts).first(used))
        task.starts.push_back(with_candidates(at.refit.explanation, view, s.set));
      task.effects = task.starts.front().effects;
      more_structure =
          more_structure || std::any_of(p.effects.begin(), p.effects.end(), structural);
      if (std::none_of(tasks.begin(), tasks.end(),
                       [&](const Task& t) { return t.effects == task.effects; }))
        tasks.push_back(std::move(task));
    }
  };
  propose(options, options.refits);
  // Series promise much, an effect that is far from straight promises less than it holds, the less
  // the more others are fitted with it.
  if (more_structure) {
    SearchOptions few = without_structure(model, options);
    propose(few, options.refits / 3);
    few.max_effects = small + 1;
    propose(few, options.refits / 3);
  }
  return tasks;
}

}  // namespace

SearchOptions without_structure(const ForwardModel& model, SearchOptions options) {
  for (std::size_t e = 0; e < model.effects().size(); ++e)
    if (model.effects()[e].structural) options.without.push_back(e);
  return options;
}

double log_evidence(const ForwardModel& model, const Refit& fit, double inflation) {
  double value = -0.5 * (fit.chi2 + fit.penalty) / inflation;
  const auto fitted = static_cast<Eigen::Index>(fit.explanation.base.size());
  // Base parameters are the same in every hypothesis: their prior volume cancels.
  Eigen::VectorXd unit(fit.precision.rows());
  for (Eigen::Index i = 0; i < fitted; ++i)
    unit[i] = 1.0 / std::sqrt(std::max(fit.precision(i, i), 1e-300));
  Eigen::Index next = fitted;
  for (std::size_t k = 0; k < fit.explanation.effects.size(); ++k) {
    const auto& declared = model.effects()[fit.explanation.effects[k]].parameters;
    for (std::size_t i = 0; i < declared.size(); ++i, ++next) {
      unit[next] = declared[i].choice ? 1.0 : declared[i].prior_u;
      const bool half = !declared[i].shape && (declared[i].lo >= declared[i].absent ||
                                               declared[i].hi <= declared[i].absent);
      if (!half) continue;
      const double sigmas = std::abs(fit.explanation.alpha[k][i] - declared[i].absent) *
                            std::sqrt(fit.precision(next, next));
      value += std::numbers::ln2 + std::log(0.5 * std::erfc(-sigmas / std::numbers::sqrt2));
    }
  }
  Eigen::MatrixXd scaled = unit.asDiagonal() * fit.precision * unit.asDiagonal();
  scaled.diagonal().array() += 1e-12;
  for (Eigen::Index i = 0; i < scaled.rows(); ++i)
    if (!(fit.precision(i, i) > 0)) scaled(i, i) = 1;  // not fitted: a choice
  const Eigen::LDLT<Eigen::MatrixXd> factor(scaled);
  // For the base alone: the determinant in the units of its own diagonal, taken out below.
  value -= 0.5 * factor.vectorD().cwiseAbs().array().max(1e-300).log().sum();
  for (Eigen::Index i = 0; i < fitted; ++i) value += std::log(unit[i]);
  return value;
}

double log_prior_odds(const ForwardModel& model) {
  const double expected =
      1.0 / static_cast<double>(std::max<std::size_t>(2, model.effects().size()));
  return std::log(expected / (1 - expected));
}

namespace {

using EffectSet = std::vector<std::size_t>;

/// One search: hypotheses by their sets of effects, each refitted once.
class Searcher {
 public:
  Searcher(const ForwardModel& model, const SearchOptions& options)
      : model_(model), options_(options), ln_odds_(log_prior_odds(model)) {}

  SearchResult run() {
    tell(0, "base model");
    result_.fold = fold_of_observations(model_.observations().row, options_.folds, options_.seed);
    const Refit base = base_fit(model_, options_.threads);
    tell(0.05, "structure of the model");
    explore(base.explanation, with_structure(model_, base, options_, result_.structure));
    settle_what_leads();
    drop_what_rests();

    for (auto& [effects, h] : known_) result_.hypotheses.push_back(std::move(h));
    std::stable_sort(
        result_.hypotheses.begin(), result_.hypotheses.end(),
        [](const Hypothesis& a, const Hypothesis& b) { return a.ln_evidence > b.ln_evidence; });
    for (std::size_t i = 0; i < result_.hypotheses.size(); ++i)
      if (result_.hypotheses[i].refit.explanation.effects.empty()) result_.base = i;
    tell(1, "done");
    return std::move(result_);
  }

 private:
  /// From a base and the structure that was taken in to hypotheses that no further look betters.
  void explore(const Explanation& bare, Refit centre) {
    learn_noise(centre);
    known_[{}] = assess(refit(model_, bare, whitening()));
    centre = refit(model_, centre.explanation, whitening());
    known_.emplace(centre.explanation.effects, assess(centre));
    std::vector<EffectSet> centres = scouted(bare, centre);
    if (centres.empty()) centres = first_centres(centre.explanation);
    // A view is good near the explanation it was taken at. Large effects move it: look again from
    // the best one found, until that does not change.
    const std::size_t further = centre.free.size() < long_structure ? 3 : 1;
    const std::size_t most_rounds = further + centres.size();
    for (std::size_t round = 0; round < centres.size() && round < most_rounds; ++round) {
      tell(0.1 + 0.8 * static_cast<double>(round) / static_cast<double>(most_rounds),
           "sets of effects");
      const EffectSet from = centres[round];
      look_around(from);
      const EffectSet& best = best_known();
      if (round + 1 == centres.size() &&
          std::find(centres.begin(), centres.end(), best) == centres.end())
        centres.push_back(best);
    }
  }

  /// Where much is missed, or the way is long through a structure of many parameters, a part of the
  /// records is enough to find the way: the best of what that finds. Nothing where it is short.
  std::vector<EffectSet> scouted(const Explanation& bare, const Refit& centre) {
    constexpr double much = 4;        // χ² per observation
    constexpr std::size_t crowd = 3;  // effects more than the structure has
    if (centre.chi2 < much * static_cast<double>(centre.residual.size()) &&
        centre.free.size() < long_structure)
      return {};
    const std::unique_ptr<ForwardModel> few = model_.thinned(most_to_find_the_way);
    if (!few) return {};
    SearchOptions silent = options_;
    silent.progress = nullptr;
    Searcher scout(*few, silent);
    scout.result_.fold =
        fold_of_observations(few->observations().row, options_.folds, options_.seed);
    scout.result_.structure = result_.structure;
    Eigen::VectorXd mean;
    few->predict(centre.explanation, mean, nullptr);
    scout.explore(bare, refit(*few, centre.explanation, Whitening(few->noise(mean))));
    const Refit& found = scout.known_.at(scout.best_known()).refit;
    const auto& effects = found.explanation.effects;
    if (effects.size() < centre.explanation.effects.size() + crowd) return {};
    known_.emplace(effects, assess(refit(model_, found.explanation, whitening())));
    return {effects};
  }

  void tell(double done, const char* what) const {
    if (options_.progress) options_.progress(done, what);
  }

  const Whitening& whitening() const { return *result_.whitening; }

  /// Noise that is not known beforehand is what the whole catalogue together cannot explain.
  void learn_noise(const Refit& centre) {
    const Whitening first(model_.noise(centre.mean));
    const LinearView view(model_, centre, first, result_.fold, true, options_.threads);
    const auto [left, kept, rank] = view.left_by_everything();
    if (!model_.noise_is_known())
      result_.noise_scale =
          std::sqrt(left.squaredNorm() / (static_cast<double>(left.size()) - rank));
    result_.relative_noise = learn_relative_noise(
        first.shape(), left.cwiseProduct(first.white_sigma()), kept, result_.noise_scale);
    result_.whitening = std::make_shared<const Whitening>(first.shape(), result_.relative_noise,
                                                          result_.noise_scale);
  }

  Hypothesis assess(Refit fit) const {
    Hypothesis h;
    h.ln_evidence =
        log_evidence(model_, fit) + ln_odds_ * static_cast<double>(fit.explanation.effects.size());
    h.refit = std::move(fit);
    return h;
  }

  /// The structure that was taken in. Where some of it took little away, and all of that together
  /// too, it may have been bent to follow an effect: then what is left without that comes first.
  std::vector<EffectSet> first_centres(const Explanation& structured) {
    constexpr double little = 2;  // χ² without it over χ² with it
    std::vector<EffectSet> centres{structured.effects};
    Explanation bare = structured;
    for (const std::size_t e : structured.effects)
      if (std::find(result_.structure.begin(), result_.structure.end(), e) ==
          result_.structure.end())
        bare = without_effect(bare, e);
    if (bare.effects.size() == structured.effects.size()) return centres;
    if (!known_.contains(bare.effects))
      known_[bare.effects] = assess(refit(model_, bare, whitening()));
    if (known_.at(bare.effects).refit.chi2 < little * known_.at(structured.effects).refit.chi2)
      centres.insert(centres.begin(), bare.effects);
    return centres;
  }

  /// Refits what the view from a known hypothesis proposes, and that without each of its effects.
  void look_around(const EffectSet& from) {
    const Hypothesis at = known_.at(from);
    const LinearView view(model_, at.refit, whitening(), result_.fold, true, options_.threads);
    if (!(result_.null_99 > 0)) {
      const std::vector<double> maxima = view.null_maxima(2000, options_.seed);
      result_.null_99 = maxima[maxima.size() * 99 / 100];
    }
    std::vector<Task> tasks = tasks_from(view, model_, at, options_, ln_odds_);
    for (std::size_t k = 0; k < from.size(); ++k) {
      if (worth_by_curvature(model_, at.refit, k) > beyond_doubt) continue;
      Explanation without = without_effect(at.refit.explanation, from[k]);
      tasks.push_back({without.effects, {without}, -infinity});
    }
    std::erase_if(tasks, [&](const Task& t) { return known_.contains(t.effects); });
    std::vector<Hypothesis> assessed(tasks.size());
    for_each_index(tasks.size(), options_.threads,
                   [&](std::size_t i) { assessed[i] = carried_out(tasks[i], at.refit); });
    for (std::size_t i = 0; i < tasks.size(); ++i)
      known_.emplace(tasks[i].effects, std::move(assessed[i]));
  }

  /// A shape far from the best one leads a refit astray: what falls short of the view's promise is
  /// tried from another. A single effect that the view misjudged needs derivatives of its own.
  Hypothesis carried_out(const Task& task, const Refit& near) const {
    Hypothesis best;
    best.ln_evidence = -infinity;
    for (const Explanation& start : task.starts) {
      Hypothesis h = assess(
          refit(model_, start, whitening(), most_iterations, model_.is_quick() ? nullptr : &near));
      if (&start == &task.starts.front() || h.ln_evidence > best.ln_evidence) best = std::move(h);
      if (best.ln_evidence > task.foretold - falls_short) break;
    }
    if (task.effects.size() == near.explanation.effects.size() + 1 &&
        std::abs(best.ln_evidence - task.foretold) > falls_short)
      best = assess(refit(model_, best.refit.explanation, whitening(), most_far_iterations));
    return best;
  }

  const EffectSet& best_known() const {
    return std::max_element(known_.begin(), known_.end(),
                            [](const auto& a, const auto& b) {
                              return a.second.ln_evidence < b.second.ln_evidence;
                            })
        ->first;
  }

  /// What leads gets derivatives of its own.
  void settle_what_leads() {
    std::vector<Hypothesis*> leading;
    for (auto& [effects, h] : known_) leading.push_back(&h);
    std::stable_sort(leading.begin(), leading.end(), [](const Hypothesis* a, const Hypothesis* b) {
      return a->ln_evidence > b->ln_evidence;
    });
    const double best = leading.front()->ln_evidence;
    if (leading.size() > most_settled) leading.resize(most_settled);
    std::erase_if(leading, [&](const Hypothesis* h) {
      return h->refit.own_derivatives || h->ln_evidence < best - worth_settling;
    });
    for_each_index(leading.size(), options_.threads, [&](std::size_t i) {
      *leading[i] = assess(refit(model_, leading[i]->refit.explanation, whitening(), 6));
    });
  }

  /// An effect that a refit put to rest at its absence is no hypothesis of its own.
  void drop_what_rests() {
    constexpr double nothing = 0.5;  // of χ²
    const auto cost = [](const Hypothesis& h) { return h.refit.chi2 + h.refit.penalty; };
    std::erase_if(known_, [&](const auto& entry) {
      return std::any_of(entry.first.begin(), entry.first.end(), [&](std::size_t e) {
        EffectSet rest = entry.first;
        std::erase(rest, e);
        const auto smaller = known_.find(rest);
        return smaller != known_.end() && cost(smaller->second) - cost(entry.second) < nothing;
      });
    });
  }

  const ForwardModel& model_;
  const SearchOptions& options_;
  double ln_odds_;
  std::map<EffectSet, Hypothesis> known_;
  SearchResult result_;
};

}  // namespace

SearchResult search(const ForwardModel& model, const SearchOptions& options) {
  return Searcher(model, options).run();
}

}  // namespace umov::gap
