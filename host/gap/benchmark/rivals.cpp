#include "host/gap/benchmark/rivals.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include <nlohmann/json.hpp>

#include "host/errors/error.hpp"
#include "host/gap/answer/diagnosis_json.hpp"
#include "host/gap/benchmark/claims.hpp"
#include "host/gap/engine/beam.hpp"
#include "host/gap/engine/linear_view.hpp"
#include "host/gap/scan/scan_model.hpp"

namespace umov::gap::benchmark {
namespace {

constexpr double two_sided_99 = 2.575829;
constexpr std::size_t most_effects = 5;     // of the forward selection
constexpr std::size_t most_structures = 3;  // of the search's, that the oracle tries
constexpr int most_iterations = 25;
constexpr std::size_t a_crowd = 8;  // effects; near the truth from the start, and slow to fit
constexpr int crowd_iterations = 6;

double objective(const Refit& fit) {
  return fit.chi2 + fit.penalty;
}

double sum(const std::vector<double>& values) {
  double total = 0;
  for (const double v : values) total += v;
  return total;
}

class Rivals {
 public:
  Rivals(const scan::ScanModel& model, const SearchOptions& options,
         const scan::ScanDiagnosis& diagnosis)
      : model_(model),
        options_(options),
        diagnosis_(diagnosis),
        whitening_(*diagnosis.answer.search.whitening),
        fold_(diagnosis.answer.search.fold),
        base_(refit(
            model,
            diagnosis.answer.search.hypotheses[diagnosis.answer.search.base].refit.explanation,
            whitening_)),
        view_(model, base_, whitening_, fold_, true, 1) {}

  Diagnosis largest_residual() const {
    std::size_t best = 0;
    double gain = 0;
    for (const std::size_t c : usable(view_)) {
      const std::size_t one[] = {c};
      const double g = view_.fit(one).gain;
      if (g > gain) {
        gain = g;
        best = c;
      }
    }
    if (gain <= diagnosis_.answer.search.null_99) return answer(base_, 0);
    return answer(fitted(view_, base_, {best}), 0);
  }

  Diagnosis forward_bic() const {
    const double ln_n = std::log(static_cast<double>(base_.residual.size()));
    std::vector<std::size_t> set;
    double gain = 0;
    while (set.size() < most_effects) {
      double most = 0, gain_then = 0;
      std::size_t best = 0;
      for (const std::size_t c : usable(view_)) {
        if (std::any_of(set.begin(), set.end(), [&](std::size_t s) {
              return view_.candidates()[s].effect == view_.candidates()[c].effect;
            }))
          continue;
        std::vector<std::size_t> larger = set;
        larger.insert(std::upper_bound(larger.begin(), larger.end(), c), c);
        const double g = view_.fit(larger).gain;
        const auto columns = static_cast<double>(view_.candidates()[c].columns.size());
        if (g - gain - columns * ln_n > most) {
          most = g - gain - columns * ln_n;
          gain_then = g;
          best = c;
        }
      }
      if (most <= 0) break;
      set.insert(std::upper_bound(set.begin(), set.end(), best), best);
      gain = gain_then;
    }
    return answer(fitted(view_, base_, set), 0);
  }

  Diagnosis oracle(const std::vector<std::string>& known) const {
    std::set<std::string> names(known.begin(), known.end());
    const bool richer = names.erase(model_cause) > 0;
    const std::optional<Cause> scatter = scatter_of(names);
    const auto answered = [&](const Refit& fit) {
      Diagnosis d = answer(fit, two_sided_99);
      if (!scatter) return d;
      d.causes.push_back(*scatter);
      d.verdict = Verdict::explained;
      return d;
    };
    const Refit from = richer ? with_structure() : base_;
    if (names.empty()) return answered(from);
    Refit best = with_names(from, names);
    // The search may have come nearer by a way of its own.
    const Refit& theirs = diagnosis_.answer.search.hypotheses.front().refit;
    Explanation shared = theirs.explanation;
    for (const std::size_t e : theirs.explanation.effects) {
      const Effect& effect = model_.effects()[e];
      if (effect.name == model_cause ? !richer : !names.contains(effect.name))
        shared = without_effect(shared, e);
    }
    if (!shared.effects.empty() && shared.effects != from.explanation.effects) {
      Refit other = with_names(shared.effects == theirs.explanation.effects
                                   ? theirs
                                   : refit(model_, shared, whitening_, most_iterations),
                               names);
      if (objective(other) < objective(best)) best = std::move(other);
    }
    return answered(best);
  }

 private:
  /// The known effect that scatters, as large as the diagnosis found it; it leaves the names. None
  /// where it is not significant.
  std::optional<Cause> scatter_of(std::set<std::string>& names) const {
    std::optional<Cause> cause;
    for (const Effect& effect : model_.effects()) {
      if (!effect.scatter || names.erase(effect.name) == 0 || !diagnosis_.answer.excess) continue;
      const ExcessVariance& found = *diagnosis_.answer.excess;
      const double error = (found.hi - found.lo) / (2 * 1.959964);
      if (!(found.size > two_sided_99 * error)) continue;
      const Parameter& size = effect.parameters.front();
      cause = Cause{effect.name,
                    effect.family,
                    1.0,
                    0.0,
                    {{size.name, size.unit, {found.size, found.lo, found.hi}}}};
    }
    return cause;
  }

  std::vector<std::size_t> usable(const LinearView& view) const {
    std::vector<std::size_t> result;
    for (std::size_t c = 0; c < view.candidates().size(); ++c) {
      const auto& without = options_.without;
      if (std::find(without.begin(), without.end(), view.candidates()[c].effect) == without.end())
        result.push_back(c);
    }
    return result;
  }

  /// A full fit from where the linear view says that these candidates lie; `from` where that fit
  /// goes astray.
  Refit fitted(const LinearView& view, const Refit& from,
               const std::vector<std::size_t>& set) const {
    if (set.empty()) return from;
    try {
      return refit(model_, with_candidates(from.explanation, view, set), whitening_,
                   set.size() > a_crowd ? crowd_iterations : most_iterations);
    } catch (const Error&) {
      return from;
    }
  }

  /// The best candidate of each named effect by itself.
  std::vector<std::size_t> one_candidate_each(const LinearView& view,
                                              const std::set<std::string>& names) const {
    std::vector<std::size_t> set;
    for (const std::string& name : names) {
      double most = -1;
      std::size_t best = view.candidates().size();
      for (std::size_t c = 0; c < view.candidates().size(); ++c) {
        if (model_.effects()[view.candidates()[c].effect].name != name) continue;
        const std::size_t one[] = {c};
        const double gain = view.fit(one).gain;
        if (gain > most) {
          most = gain;
          best = c;
        }
      }
      if (best < view.candidates().size()) set.push_back(best);
    }
    std::sort(set.begin(), set.end());
    return set;
  }

  /// `fit` with those of the effects that it lacks.
  Refit with_names(const Refit& fit, std::set<std::string> names) const {
    for (const std::size_t e : fit.explanation.effects) names.erase(model_.effects()[e].name);
    if (names.empty()) return fit;
    const LinearView view(model_, fit, whitening_, fold_, true, 1);
    return fitted(view, fit, one_candidate_each(view, names));
  }

  /// The base with the richer reflectance that the best of the search's hypotheses have, whichever
  /// has the most evidence by itself.
  Refit with_structure() const {
    Refit best = base_;
    double evidence = log_evidence(model_, base_);
    std::set<std::vector<std::size_t>> tried;
    for (const Hypothesis& h : diagnosis_.answer.search.hypotheses) {
      Explanation part = h.refit.explanation;
      for (const std::size_t e : h.refit.explanation.effects)
        if (model_.effects()[e].name != model_cause) part = without_effect(part, e);
      if (part.effects.empty() || !tried.insert(part.effects).second) continue;
      if (tried.size() > most_structures) break;
      Refit fit = refit(model_, part, whitening_, most_iterations);
      const double value = log_evidence(model_, fit) +
                           log_prior_odds(model_) * static_cast<double>(part.effects.size());
      if (value <= evidence) continue;
      evidence = value;
      best = std::move(fit);
    }
    return best;
  }

  /// `least_z`: effects whose principal parameter is less significant are fitted but not named.
  Diagnosis answer(const Refit& fit, double least_z) const {
    Diagnosis d;
    d.before = diagnosis_.answer.before;
    d.floor = diagnosis_.answer.floor;
    const double held_out =
        sum(LinearView(model_, fit, whitening_, fold_, false, 1).held_out_by_fold());
    const auto n = static_cast<double>(fit.residual.size());
    d.after.g2 = held_out / n - 1;
    const double sharpness = fit.mean.cwiseQuotient(whitening_.white_sigma()).squaredNorm() / n;
    d.after.percent = 100 * std::sqrt(std::max(0.0, d.after.g2) / std::max(sharpness, 1e-300));
    const double whole = d.before.g2 - d.floor.g2;
    const double closed = whole > 0 ? (d.before.g2 - d.after.g2) / whole : 0;
    d.closed_fraction = {closed, closed, closed};
    name_causes(d, fit, least_z);
    d.verdict = d.causes.empty() ? Verdict::none_needed : Verdict::explained;
    return d;
  }

  void name_causes(Diagnosis& d, const Refit& fit, double least_z) const {
    const Eigen::VectorXd error = standard_errors(fit.precision);
    auto next = static_cast<Eigen::Index>(fit.explanation.base.size());
    double total = 0;
    for (std::size_t k = 0; k < fit.explanation.effects.size(); ++k) {
      const Effect& effect = model_.effects()[fit.explanation.effects[k]];
      Cause cause{effect.name, effect.family, 1.0, 0.0, {}};
      double z = 0;
      for (std::size_t i = 0; i < effect.parameters.size(); ++i, ++next) {
        const Parameter& p = effect.parameters[i];
        const double value = fit.explanation.alpha[k][i];
        cause.parameters.push_back(named_value(p, value, error[next]));
        if (i == 0 && error[next] > 0) z = std::abs(value - p.absent) / error[next];
      }
      if (!(z >= least_z)) continue;
      cause.share = z * z;
      total += cause.share;
      d.causes.push_back(std::move(cause));
    }
    for (Cause& cause : d.causes) cause.share /= std::max(total, 1e-300);
    std::stable_sort(d.causes.begin(), d.causes.end(),
                     [](const Cause& a, const Cause& b) { return a.share > b.share; });
  }

  const scan::ScanModel& model_;
  const SearchOptions& options_;
  const scan::ScanDiagnosis& diagnosis_;
  const Whitening& whitening_;
  const std::vector<int>& fold_;
  Refit base_;
  LinearView view_;
};

}  // namespace

std::string rival_answers(const std::vector<formats::ScanTable>& scans,
                          const scan::ScanDiagnoseOptions& options,
                          const scan::ScanDiagnosis& diagnosis,
                          const std::optional<std::vector<std::string>>& known) {
  const scan::ScanModel model(scans, options.model);
  SearchOptions search = options.diagnose.search;
  search.without.clear();
  for (std::size_t e = 0; e < model.effects().size(); ++e) {
    const auto& names = options.without;
    if (std::find(names.begin(), names.end(), model.effects()[e].name) != names.end())
      search.without.push_back(e);
  }
  const Rivals rivals(model, search, diagnosis);
  AnswerSource source;
  source.records = diagnosis.records;
  source.used = diagnosis.used;
  source.seed = search.seed;
  source.model = diagnosis.model;
  nlohmann::ordered_json all;
  const auto add = [&](const char* name, const Diagnosis& answer) {
    auto json = nlohmann::ordered_json::parse(diagnosis_to_json(answer, source));
    // What these do not have.
    for (const char* key : {"where", "unexplained", "next_scan", "probabilities", "base", "data",
                            "program", "ambiguity_sets"})
      json.erase(key);
    json["ambiguity_sets"] = nlohmann::json::array();
    all[name] = std::move(json);
  };
  add("largest_residual", rivals.largest_residual());
  add("forward_bic", rivals.forward_bic());
  if (known) {
    try {
      add("oracle", rivals.oracle(*known));
    } catch (const Error&) {
      // Where the known effects cannot be fitted there is no mark to be compared with.
      all["oracle"] = nullptr;
    }
  }
  return all.dump(1) + "\n";
}

}  // namespace umov::gap::benchmark
