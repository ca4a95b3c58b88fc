#include "host/gap/engine/variation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <Eigen/QR>

#include "host/parallel/for_each_index.hpp"

namespace umov::gap {
namespace {

/// Up to so many values of a circumstance are settings of which each may have its own error.
constexpr std::size_t most_levels = 8;
constexpr int steps = 12;
constexpr int trends = 2;
/// Periods to a circumstance's whole range, in steps of a half: as many as its values can show.
constexpr double few_cycles = 6;
constexpr double most_cycles = 40;
constexpr double cycle_step = 0.5;
/// Share of a signature's squared length that must survive the fit.
constexpr double least_survival = 1e-3;
/// Observations that must carry it: a single outlier is no circumstance.
constexpr double fewest_carrying = 6;

/// One or two functions on the observations that act together.
struct Pattern {
  const Circumstance* with;
  Variation::Kind kind;
  double at;
  Eigen::MatrixXd factor;  // one row an observation
  bool often = false;      // repeats many times over the range
};

std::vector<Pattern> patterns_of(const Circumstance& circumstance) {
  const std::vector<double>& value = circumstance.axis.value;
  const auto n = static_cast<Eigen::Index>(value.size());
  std::vector<double> sorted = value;
  std::sort(sorted.begin(), sorted.end());
  std::vector<double> distinct = sorted;
  distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());
  std::vector<Pattern> patterns;
  if (distinct.size() < 2) return patterns;
  const auto add = [&](Variation::Kind kind, double at, Eigen::Index columns, const auto& f) {
    Pattern p{&circumstance, kind, at, Eigen::MatrixXd(n, columns)};
    for (Eigen::Index i = 0; i < n; ++i)
      for (Eigen::Index c = 0; c < columns; ++c)
        p.factor(i, c) = f(value[static_cast<std::size_t>(i)], c);
    patterns.push_back(std::move(p));
  };
  if (distinct.size() <= most_levels) {
    // Of two values one is enough: the other is all that is left.
    const std::size_t count = distinct.size() == 2 ? 1 : distinct.size();
    for (std::size_t k = 0; k < count; ++k)
      add(Variation::Kind::level, distinct[k], 1,
          [&](double v, Eigen::Index) { return v == distinct[k] ? 1.0 : 0.0; });
    return patterns;
  }
  const double from = distinct.front(), range = distinct.back() - from;
  for (int s = 1; s < steps; ++s) {
    const double edge = sorted[sorted.size() * static_cast<std::size_t>(s) / steps];
    add(Variation::Kind::step, edge, 1,
        [&](double v, Eigen::Index) { return v >= edge ? 1.0 : 0.0; });
  }
  for (int t = 1; t <= trends; ++t)
    add(Variation::Kind::trend, t, 1,
        [&](double v, Eigen::Index) { return std::pow(2 * (v - from) / range - 1, t); });
  const double most =
      circumstance.repeats_in.empty()
          ? few_cycles
          : std::clamp(0.5 * static_cast<double>(distinct.size() - 1), few_cycles, most_cycles);
  for (double cycles = 1; cycles <= most; cycles += cycle_step) {
    add(Variation::Kind::swing, range / cycles, 2, [&](double v, Eigen::Index c) {
      const double phase = 2 * std::numbers::pi * cycles * (v - from) / range;
      return c == 0 ? std::sin(phase) : std::cos(phase);
    });
    patterns.back().often = cycles > few_cycles;
  }
  return patterns;
}

/// Something known, as it would show if it were a little different everywhere.
struct Carrier {
  std::string what, stage;
  bool of_object;  // the thing measured, not the instrument
  Eigen::VectorXd signature;
};

std::vector<Carrier> carriers_of(const ForwardModel& model, const Refit& fit, int threads) {
  struct Task {
    std::string what, stage;
    bool of_object;
    Explanation moved;
  };
  std::vector<Task> tasks;
  const Explanation& at = fit.explanation;
  const Eigen::VectorXd errors = standard_errors(fit.precision);
  for (std::size_t e = 0; e < model.effects().size(); ++e) {
    const Effect& effect = model.effects()[e];
    if (effect.structural || effect.probes.empty()) continue;
    const bool there = std::find(at.effects.begin(), at.effects.end(), e) != at.effects.end();
    tasks.push_back(
        {effect.name, effect.stage, effect.of_object,
         there ? without_effect(at, e) : with_effect(at, e, effect.probes.front().front())});
  }
  for (std::size_t i = 0; i < model.base().size(); ++i) {
    const Parameter& p = model.base()[i];
    const double error = errors[static_cast<Eigen::Index>(i)];
    if (!(p.lo < p.hi) || !(error > 0) || !std::isfinite(error)) continue;
    Explanation moved = at;
    moved.base[i] += at.base[i] + error < p.hi ? error : -error;
    if (moved.base[i] > p.lo && moved.base[i] < p.hi)
      tasks.push_back({p.name, "", true, std::move(moved)});
  }
  std::vector<Carrier> carriers(tasks.size());
  for_each_index(tasks.size(), threads, [&](std::size_t i) {
    Eigen::VectorXd moved;
    model.predict(tasks[i].moved, moved, nullptr);
    carriers[i] = {tasks[i].what, tasks[i].stage, tasks[i].of_object, moved - fit.mean};
  });
  std::erase_if(carriers, [](const Carrier& c) {
    return !c.signature.allFinite() || !(c.signature.squaredNorm() > 0);
  });
  carriers.push_back({"signal", "", false, fit.mean});
  return carriers;
}

}  // namespace

const char* to_string(Variation::Kind kind) {
  switch (kind) {
    case Variation::Kind::level:
      return "level";
    case Variation::Kind::trend:
      return "trend";
    case Variation::Kind::step:
      return "step";
    case Variation::Kind::swing:
      return "swing";
    case Variation::Kind::wander:
      return "wander";
  }
  return "";
}

Variation slow_wander(const ForwardModel& model, const Refit& fit, const Whitening& whitening,
                      double noise_scale) {
  const RelativeNoise& learned = whitening.relative();
  if (!(learned.slow > 0)) return {};
  const Eigen::VectorXd left = model.observations().value - fit.mean;
  const auto misfit = [&](const Whitening& w) {
    return 2 * w.ln_determinant() + w.apply(left).squaredNorm();
  };
  const double with = misfit(whitening);
  double without = std::numeric_limits<double>::infinity();
  for (int step = 0; step <= 40; ++step) {
    // All that the two parts have together, down to nothing.
    RelativeNoise steady = learned;
    steady.white = std::hypot(learned.white, learned.slow) * (1 - 0.025 * step);
    steady.slow = steady.memory = 0;
    without = std::min(without, misfit(Whitening(whitening.shape(), steady, noise_scale)));
  }
  // Its size and memory were looked for over a grid of thirty.
  constexpr double looked_at = 30;
  const double gain = std::max(0.0, without - with);
  return {"signal",
          "time",
          "1",
          Variation::Kind::wander,
          learned.slow,
          {},
          gain,
          std::min(1.0, looked_at * std::exp(-0.5 * gain)),
          {}};
}

Variation strongest_variation(const ForwardModel& model, const Refit& fit,
                              const Whitening& whitening, double known_gain, int threads) {
  std::vector<Pattern> patterns;
  for (const Circumstance& c : model.observations().circumstances) {
    std::vector<Pattern> own = patterns_of(c);
    std::move(own.begin(), own.end(), std::back_inserter(patterns));
  }
  if (patterns.empty()) return {};
  const std::vector<Carrier> carriers = carriers_of(model, fit, threads);

  const Eigen::Index n = fit.residual.size();
  const auto fitted = static_cast<Eigen::Index>(fit.free.size());
  // Priors are further observations, of the parameters themselves.
  Eigen::MatrixXd basis(n + fitted, fitted);
  basis.topRows(n) = fit.jacobian(Eigen::all, fit.free);
  basis.bottomRows(fitted) =
      Eigen::MatrixXd(fit.prior_precision(fit.free).cwiseSqrt().asDiagonal());
  for (Eigen::Index i = 0; i < fitted; ++i) {
    const double size = basis.col(i).norm();
    if (size > 0) basis.col(i) /= size;
  }
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> factor(basis);
  const Eigen::MatrixXd q =
      (factor.householderQ() * Eigen::MatrixXd::Identity(basis.rows(), factor.rank())).topRows(n);

  std::vector<Variation> best(carriers.size());
  std::vector<double> least_p(carriers.size(), 1.0);
  std::vector<std::size_t> looked(carriers.size(), 0);
  std::vector<double> constant(carriers.size(), 0.0);
  for_each_index(carriers.size(), threads, [&](std::size_t k) {
    const Carrier& carrier = carriers[k];
    Eigen::Index columns = 0;
    std::vector<const Pattern*> own;
    for (const Pattern& p : patterns) {
      if (carrier.of_object && p.with->of_object) continue;
      const bool whole = &carrier == &carriers.back();
      if (p.often && !whole && carrier.stage != p.with->repeats_in) continue;
      own.push_back(&p);
      columns += p.factor.cols();
    }
    Eigen::MatrixXd signature(n, columns);
    Eigen::Index next = 0;
    for (const Pattern* p : own) {
      signature.middleCols(next, p->factor.cols()) = carrier.signature.asDiagonal() * p->factor;
      next += p->factor.cols();
    }
    // Most show in few observations (in phase, or at low signal): the others cost nothing.
    const Eigen::VectorXd plain = whitening.apply(carrier.signature);
    std::vector<Eigen::Index> shown;
    for (Eigen::Index i = 0; i < n; ++i)
      if (plain[i] != 0) shown.push_back(i);
    signature = Eigen::MatrixXd(whitening.apply(signature)(shown, Eigen::all));
    const Eigen::MatrixXd basis_shown = q(shown, Eigen::all);
    const Eigen::MatrixXd absorbed = basis_shown.transpose() * signature;
    {
      const Eigen::VectorXd own_signature = plain(shown);
      const double size = own_signature.squaredNorm();
      const double left = size - (basis_shown.transpose() * own_signature).squaredNorm();
      const double pull = own_signature.dot(fit.residual(shown));
      if (left > least_survival * size) constant[k] = pull * pull / left;
    }
    const Eigen::VectorXd right = signature.transpose() * fit.residual(shown);
    next = 0;
    for (const Pattern* p : own) {
      const Eigen::Index first = next, count = p->factor.cols();
      next += count;
      const auto part = signature.middleCols(first, count);
      const auto taken = absorbed.middleCols(first, count);
      Eigen::MatrixXd gram = part.transpose() * part;
      const double whole = gram.trace();
      // How many observations it rests on: the inverse of the sum of squared shares.
      const double fourth = part.array().square().square().sum();
      if (!(whole > 0) || whole * whole < fewest_carrying * fourth) continue;
      gram -= taken.transpose() * taken;
      const Eigen::VectorXd r = right.segment(first, count);
      double gain = 0;
      bool seen = true;
      if (count == 1) {
        seen = gram(0, 0) > least_survival * whole;
        if (seen) gain = r[0] * r[0] / gram(0, 0);
      } else {
        const double det = gram(0, 0) * gram(1, 1) - gram(0, 1) * gram(1, 0);
        seen = gram.trace() > least_survival * whole && det > 1e-6 * gram.trace() * gram.trace();
        if (seen)
          gain =
              (r[0] * r[0] * gram(1, 1) - 2 * r[0] * r[1] * gram(0, 1) + r[1] * r[1] * gram(0, 0)) /
              det;
      }
      if (!seen) continue;
      ++looked[k];
      const double chance = count == 1 ? std::erfc(std::sqrt(0.5 * gain)) : std::exp(-0.5 * gain);
      // Far out all chances round to zero: the larger gain wins there.
      if (chance < least_p[k] || (chance == least_p[k] && gain > best[k].gain)) {
        least_p[k] = chance;
        std::string name;
        for (const auto& [value, said] : p->with->names)
          if (p->kind == Variation::Kind::level && p->at == value) name = said;
        best[k] = {carrier.what,
                   p->with->axis.name,
                   p->with->axis.unit,
                   p->kind,
                   p->at,
                   name,
                   gain,
                   1,
                   Eigen::MatrixXd::Zero(n, count)};
        best[k].signature(shown, Eigen::all) = part;
      }
    }
  });
  std::size_t strongest = 0, tests = 0;
  for (std::size_t k = 0; k < carriers.size(); ++k) {
    tests += looked[k];
    if (least_p[k] < least_p[strongest] ||
        (least_p[k] == least_p[strongest] && best[k].gain > best[strongest].gain))
      strongest = k;
  }
  Variation variation = std::move(best[strongest]);
  // What a known effect that is constant does as well, though not enough to be named, is no sign of
  // one that is not.
  const double known = *std::max_element(constant.begin(), constant.end());
  double chance = least_p[strongest];
  if (known > known_gain) {
    const double beyond = std::max(0.0, variation.gain - known);
    chance = variation.signature.cols() == 1 ? std::erfc(std::sqrt(0.5 * beyond))
                                             : std::exp(-0.5 * beyond);
  }
  variation.p_global = std::min(1.0, chance * static_cast<double>(tests));
  return variation;
}

}  // namespace umov::gap
