#include "host/gap/engine/search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <set>
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
/// Starts of a single effect (of a set: two), and how far below the linear view's ln of the
/// evidence a refit makes the next worth trying.
constexpr std::size_t most_starts = 4;
constexpr double falls_short = 5;
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
      const std::size_t used =
          std::min(p.starts.size(), p.effects.size() == 1 ? most_starts : std::size_t{2});
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

double log_prior_odds(const ForwardModel& model, const SearchOptions& options) {
  const double expected =
      options.prior_probability > 0
          ? options.prior_probability
          : 1.0 / static_cast<double>(std::max<std::size_t>(2, model.effects().size()));
  return std::log(expected / (1 - expected));
}

SearchResult search(const ForwardModel& model, const SearchOptions& options) {
  SearchResult result;
  const auto tell = [&](double done, const char* what) {
    if (options.progress) options.progress(done, what);
  };
  tell(0, "base model");
  result.fold = fold_of_observations(model.observations().row, options.folds, options.seed);

  Refit base = base_fit(model, options.threads);
  tell(0.05, "structure of the model");
  Refit centre = with_structure(model, base, options, result.structure);
  Whitening whitening(model.noise(centre.mean));
  {
    // Noise that is not known beforehand is what the whole catalogue together cannot explain.
    const LinearView view(model, centre, whitening, result.fold, true, options.threads);
    const NoiseShape& shape = whitening.shape();
    const auto [left, kept, rank] = view.left_by_everything();
    if (!model.noise_is_known())
      result.noise_scale =
          std::sqrt(left.squaredNorm() / (static_cast<double>(left.size()) - rank));
    result.relative_noise = learn_relative_noise(shape, left.cwiseProduct(whitening.white_sigma()),
                                                 kept, result.noise_scale);
    whitening = Whitening(shape, result.relative_noise, result.noise_scale);
    result.whitening = std::make_shared<Whitening>(whitening);
    base = refit(model, base.explanation, whitening);
    centre = refit(model, centre.explanation, whitening);
  }

  const double ln_odds = log_prior_odds(model, options);
  // Sets of effects, each refitted once, by their numbers.
  std::map<std::vector<std::size_t>, Hypothesis> known;
  const auto assess = [&](Refit fit) {
    Hypothesis h;
    h.ln_evidence =
        log_evidence(model, fit) + ln_odds * static_cast<double>(fit.explanation.effects.size());
    h.refit = std::move(fit);
    return h;
  };
  known[{}] = assess(base);
  if (!centre.explanation.effects.empty()) known[centre.explanation.effects] = assess(centre);

  // The view is good near the explanation it was taken at. Large effects move it: look again from
  // the best one found, until that does not change. Structure that took little away may have been
  // bent to follow an effect: then look from the base too.
  std::vector<std::size_t> best_effects = centre.explanation.effects;
  std::vector<std::vector<std::size_t>> centres{best_effects};
  {
    Explanation bare = centre.explanation;
    for (const std::size_t e : centre.explanation.effects)
      if (std::find(result.structure.begin(), result.structure.end(), e) == result.structure.end())
        bare = without_effect(bare, e);
    if (bare.effects.size() < best_effects.size()) {
      if (!known.contains(bare.effects))
        known[bare.effects] = assess(refit(model, bare, whitening));
      centres.insert(centres.begin(), bare.effects);
    }
  }
  const std::size_t most_rounds = 4 + centres.size();
  for (std::size_t round = 0; round < centres.size() && round < most_rounds; ++round) {
    tell(0.1 + 0.2 * static_cast<double>(round), "sets of effects");
    const std::vector<std::size_t> from = centres[round];
    const Hypothesis at = known.at(from);
    const LinearView view(model, at.refit, whitening, result.fold, true, options.threads);
    if (from == centre.explanation.effects) {
      const std::vector<double> maxima = view.null_maxima(2000, options.seed);
      result.null_99 = maxima[maxima.size() * 99 / 100];
    }
    std::vector<Task> tasks = tasks_from(view, model, at, options, ln_odds);
    std::erase_if(tasks, [&](const Task& t) { return known.contains(t.effects); });
    // Backward: each effect of the centre on trial.
    for (const std::size_t e : from) {
      Explanation without = without_effect(at.refit.explanation, e);
      if (known.contains(without.effects)) continue;
      tasks.push_back({without.effects, {without}, -infinity});
    }
    std::vector<Hypothesis> assessed(tasks.size());
    for_each_index(tasks.size(), options.threads, [&](std::size_t i) {
      // A shape far from the best one leads a refit astray: what falls short of the view's promise
      // is tried from another.
      for (const Explanation& start : tasks[i].starts) {
        Hypothesis h = assess(refit(model, start, whitening, most_iterations, &at.refit));
        if (&start == &tasks[i].starts.front() || h.ln_evidence > assessed[i].ln_evidence)
          assessed[i] = std::move(h);
        if (assessed[i].ln_evidence > tasks[i].foretold - falls_short) break;
      }
      // A single effect that the view misjudged needs derivatives of its own.
      if (tasks[i].effects.size() == from.size() + 1 &&
          std::abs(assessed[i].ln_evidence - tasks[i].foretold) > falls_short)
        assessed[i] =
            assess(refit(model, assessed[i].refit.explanation, whitening, most_far_iterations));
    });
    for (std::size_t i = 0; i < tasks.size(); ++i)
      known.emplace(tasks[i].effects, std::move(assessed[i]));

    double best = -infinity;
    for (const auto& [effects, h] : known) {
      if (h.ln_evidence > best) {
        best = h.ln_evidence;
        best_effects = effects;
      }
    }
    if (round + 1 == centres.size() &&
        std::find(centres.begin(), centres.end(), best_effects) == centres.end())
      centres.push_back(best_effects);
  }

  // What leads is settled with its own derivatives.
  {
    std::vector<Hypothesis*> leading;
    for (auto& [effects, h] : known) leading.push_back(&h);
    std::stable_sort(leading.begin(), leading.end(), [](const Hypothesis* a, const Hypothesis* b) {
      return a->ln_evidence > b->ln_evidence;
    });
    const double best = leading.front()->ln_evidence;
    if (leading.size() > most_settled) leading.resize(most_settled);
    std::erase_if(leading, [&](const Hypothesis* h) {
      return h->refit.own_derivatives || h->ln_evidence < best - worth_settling;
    });
    for_each_index(leading.size(), options.threads, [&](std::size_t i) {
      *leading[i] = assess(refit(model, leading[i]->refit.explanation, whitening, 6));
    });
  }

  // An effect that a refit put to rest at its absence is no hypothesis of its own.
  std::erase_if(known, [&](const auto& entry) {
    for (const std::size_t e : entry.first) {
      const auto smaller = known.find([&] {
        std::vector<std::size_t> rest = entry.first;
        std::erase(rest, e);
        return rest;
      }());
      if (smaller != known.end() && smaller->second.refit.chi2 + smaller->second.refit.penalty -
                                            entry.second.refit.chi2 - entry.second.refit.penalty <
                                        0.5)
        return true;
    }
    return false;
  });

  for (auto& [effects, h] : known) result.hypotheses.push_back(std::move(h));
  std::stable_sort(
      result.hypotheses.begin(), result.hypotheses.end(),
      [](const Hypothesis& a, const Hypothesis& b) { return a.ln_evidence > b.ln_evidence; });
  for (std::size_t i = 0; i < result.hypotheses.size(); ++i)
    if (result.hypotheses[i].refit.explanation.effects.empty()) result.base = i;
  tell(1, "done");
  return result;
}

}  // namespace umov::gap
