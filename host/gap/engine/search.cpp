#include "host/gap/engine/search.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include <Eigen/Cholesky>

#include "host/gap/engine/beam.hpp"
#include "host/gap/engine/folds.hpp"
#include "host/gap/engine/structure.hpp"
#include "host/parallel/for_each_index.hpp"

namespace umov::gap {
namespace {

/// Of a refit in the search.
constexpr int most_iterations = 8;
/// ln of the odds against the best beyond which a hypothesis need not be settled to the last digit.
constexpr double worth_settling = 4;
constexpr std::size_t most_settled = 6;

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

}  // namespace

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
  // the best one found, until that does not change.
  std::vector<std::size_t> from = centre.explanation.effects;
  std::set<std::vector<std::size_t>> seen;
  for (int round = 0; round < 3 && seen.insert(from).second; ++round) {
    tell(0.1 + 0.2 * round, "sets of effects");
    const Hypothesis at = known.at(from);
    const LinearView view(model, at.refit, whitening, result.fold, true, options.threads);
    if (round == 0) {
      const std::vector<double> maxima = view.null_maxima(2000, options.seed);
      result.null_99 = maxima[maxima.size() * 99 / 100];
    }
    const auto small = std::count_if(from.begin(), from.end(),
                                     [&](std::size_t e) { return !model.effects()[e].structural; });
    Beam beam(view, options, ln_odds, static_cast<std::size_t>(small));
    struct Task {
      std::vector<std::size_t> effects;
      Explanation start;
    };
    std::vector<Task> tasks;
    const auto add_task = [&](Explanation explanation) {
      const std::vector<std::size_t> effects = explanation.effects;
      if (known.contains(effects)) return;
      for (const Task& t : tasks)
        if (t.effects == effects) return;
      tasks.push_back({effects, std::move(explanation)});
    };
    for (const ScoredSet& scored : beam.run()) {
      if (tasks.size() >= options.refits) break;
      add_task(with_candidates(at.refit.explanation, view, scored.set));
    }
    // Backward: each effect of the centre on trial.
    for (const std::size_t e : from) {
      add_task(without_effect(at.refit.explanation, e));
    }
    std::vector<Hypothesis> assessed(tasks.size());
    for_each_index(tasks.size(), options.threads, [&](std::size_t i) {
      assessed[i] = assess(refit(model, tasks[i].start, whitening, most_iterations, &at.refit));
    });
    for (std::size_t i = 0; i < tasks.size(); ++i)
      known.emplace(tasks[i].effects, std::move(assessed[i]));

    double best = -1e300;
    for (const auto& [effects, h] : known) {
      if (h.ln_evidence > best) {
        best = h.ln_evidence;
        from = effects;
      }
    }
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
