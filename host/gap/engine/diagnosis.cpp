#include "host/gap/engine/diagnosis.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <set>

#include <Eigen/Cholesky>

#include "host/gap/engine/folds.hpp"

namespace umov::gap {
namespace {

constexpr double two_sided_95 = 1.959964;

Eigen::VectorXd standard_errors(const Eigen::MatrixXd& precision) {
  const Eigen::VectorXd scale = precision.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  Eigen::MatrixXd scaled = scale.asDiagonal() * precision * scale.asDiagonal();
  for (Eigen::Index i = 0; i < scaled.rows(); ++i)
    if (!(precision(i, i) > 0)) scaled(i, i) = 1;
  scaled.diagonal().array() += 1e-10;
  const Eigen::MatrixXd inverse =
      scaled.ldlt().solve(Eigen::MatrixXd::Identity(scaled.rows(), scaled.cols()));
  Eigen::VectorXd errors(scaled.rows());
  for (Eigen::Index i = 0; i < errors.size(); ++i)
    errors[i] = precision(i, i) > 0 ? std::sqrt(std::max(0.0, inverse(i, i))) * scale[i] : 0.0;
  return errors;
}

NamedValue named_value(const Parameter& p, double value, double error) {
  return {p.name,
          p.unit,
          {value, std::max(p.lo, value - two_sided_95 * error),
           std::min(p.hi, value + two_sided_95 * error)}};
}

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

/// Shares of the accepted effects in what they close together (Shapley: the mean over all orders of
/// taking them in).
std::vector<double> shapley(const std::vector<double>& value_of_subset, std::size_t n) {
  std::vector<double> share(n, 0.0);
  std::vector<double> factorial(n + 1, 1.0);
  for (std::size_t i = 1; i <= n; ++i) factorial[i] = factorial[i - 1] * static_cast<double>(i);
  for (std::size_t subset = 0; subset < value_of_subset.size(); ++subset) {
    const auto size = static_cast<std::size_t>(__builtin_popcountll(subset));
    for (std::size_t i = 0; i < n; ++i) {
      if ((subset >> i) & 1U) continue;
      const double weight = factorial[size] * factorial[n - size - 1] / factorial[n];
      share[i] +=
          weight * (value_of_subset[subset | (std::size_t{1} << i)] - value_of_subset[subset]);
    }
  }
  return share;
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
    const Hypothesis& base = d_.search.hypotheses[d_.search.base];
    const Whitening& whitening = *d_.search.whitening;
    d_.where = find_where(model_, base.refit, options_.draws, options_.search.seed + 1);
    probabilities();

    const Hypothesis& best = d_.search.hypotheses.front();
    final_ = accepted(best, base);
    const Refit& after = final_->refit;
    d_.unexplained = find_where(model_, after, options_.draws, options_.search.seed + 2);
    gaps(base.refit, after, whitening);
    causes(base.refit, after, whitening);
    ambiguity(*final_, whitening);
    verdict();
    const Eigen::VectorXd errors = standard_errors(after.precision);
    for (std::size_t i = 0; i < model_.base().size(); ++i)
      d_.base.push_back(named_value(model_.base()[i], after.explanation.base[i],
                                    errors[static_cast<Eigen::Index>(i)]));
    return std::move(d_);
  }

 private:
  /// The best hypothesis, if evidence and withheld rows agree that it is better than the base.
  const Hypothesis* accepted(const Hypothesis& best, const Hypothesis& base) const {
    const bool gain = base.refit.chi2 - best.refit.chi2 > d_.search.null_99;
    const bool predicts = best.held_out_chi2 < base.held_out_chi2;
    return gain && predicts ? &best : &base;
  }

  void probabilities() {
    std::map<std::string, double> by_name;
    for (std::size_t e = 0; e < model_.effects().size(); ++e)
      by_name[model_.effects()[e].name] += d_.search.inclusion[e];
    for (auto& [name, p] : by_name) d_.probabilities.emplace_back(name, std::min(1.0, p));
    std::stable_sort(d_.probabilities.begin(), d_.probabilities.end(),
                     [](const auto& a, const auto& b) { return a.second > b.second; });
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
    const std::vector<double> b = held_out_by_fold(model_, base, whitening, fold);
    const std::vector<double> a = held_out_by_fold(model_, after, whitening, fold);
    const LinearView view(model_, after, whitening, fold, false);
    const double floor = view.held_out_floor(options_.draws, options_.search.seed + 3);
    d_.before = size_of(sum(b), base, whitening);
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
    if (chosen.empty()) return;
    // What every subset closes on withheld rows.
    const std::size_t n = chosen.size();
    std::vector<double> closed(std::size_t{1} << n, 0.0);
    const double nothing = sum(held_out_by_fold(model_, base, whitening, d_.search.fold));
    for (std::size_t subset = 1; subset < closed.size(); ++subset) {
      Explanation part = after.explanation;
      for (std::size_t i = 0; i < n; ++i)
        if (!((subset >> i) & 1U)) part = without_effect(part, chosen[i]);
      const Refit fit = subset + 1 == closed.size() ? after : refit(model_, part, whitening);
      closed[subset] = nothing - sum(held_out_by_fold(model_, fit, whitening, d_.search.fold));
    }
    const std::vector<double> share = shapley(closed, n);
    const double whole = std::max(closed.back(), 1e-300);
    const Eigen::VectorXd errors = standard_errors(after.precision);
    Eigen::Index next = static_cast<Eigen::Index>(after.explanation.base.size());
    for (std::size_t k = 0; k < n; ++k) {
      const Effect& effect = model_.effects()[chosen[k]];
      Cause cause{effect.name, effect.family, probability_of(effect.name), share[k] / whole, {}};
      for (std::size_t i = 0; i < effect.parameters.size(); ++i, ++next)
        cause.parameters.push_back(
            named_value(effect.parameters[i], after.explanation.alpha[k][i], errors[next]));
      if (cause.probability >= options_.named) d_.causes.push_back(std::move(cause));
    }
    std::stable_sort(d_.causes.begin(), d_.causes.end(),
                     [](const Cause& a, const Cause& b) { return a.share > b.share; });
  }

  /// Each cause on trial against every other effect in its place.
  void ambiguity(const Hypothesis& best, const Whitening& whitening) {
    std::vector<std::set<std::string>> sets;
    const double ln_odds = log_prior_odds(model_, options_.search);
    for (const std::size_t member : best.refit.explanation.effects) {
      std::set<std::string> set{model_.effects()[member].name};
      const Refit smaller =
          refit(model_, without_effect(best.refit.explanation, member), whitening);
      const LinearView view(model_, smaller, whitening, d_.search.fold);
      std::vector<std::pair<double, std::size_t>> rivals;
      for (std::size_t c = 0; c < view.candidates().size(); ++c) {
        if (view.candidates()[c].effect == member) continue;
        const std::size_t one[] = {c};
        rivals.emplace_back(-view.fit(one).ln_evidence, c);
      }
      std::sort(rivals.begin(), rivals.end());
      std::set<std::size_t> tried;
      for (const auto& [cost, c] : rivals) {
        if (tried.size() == 5) break;
        const std::size_t effect = view.candidates()[c].effect;
        if (!tried.insert(effect).second) continue;
        const std::size_t one[] = {c};
        const Refit fit = refit(
            model_,
            with_effect(smaller.explanation, effect, view.alpha(c, view.fit(one).coefficient)),
            whitening);
        const double ln_evidence = log_evidence(model_, fit) +
                                   ln_odds * static_cast<double>(fit.explanation.effects.size());
        if (2 * (best.ln_evidence - ln_evidence) < options_.ambiguous)
          set.insert(model_.effects()[effect].name);
      }
      sets.push_back(std::move(set));
    }
    d_.ambiguity_sets = merged(std::move(sets));
  }

  void verdict() {
    const bool left = d_.unexplained.p_global < options_.significance;
    if (final_->refit.explanation.effects.empty()) {
      d_.verdict = left ? Verdict::unexplained : Verdict::none_needed;
    } else if (d_.causes.empty() && d_.ambiguity_sets.empty()) {
      d_.verdict = Verdict::unexplained;
    } else {
      d_.verdict = left ? Verdict::explained_in_part : Verdict::explained;
    }
  }

  const ForwardModel& model_;
  const DiagnoseOptions& options_;
  const Hypothesis* final_ = nullptr;
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

Diagnosis diagnose(const ForwardModel& model, const DiagnoseOptions& options) {
  return Diagnoser(model, options).run();
}

}  // namespace umov::gap
