#include "host/gap/engine/variation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

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

/// Decrease of χ² by one or two columns whose Gram matrix is `gram` and that pull with `right`;
/// negative where the fit has taken up so much of their squared length `whole` that nothing is
/// seen.
double gain_of(const Eigen::MatrixXd& gram, const Eigen::VectorXd& right, double whole) {
  constexpr double unseen = -1;
  if (!(gram.trace() > least_survival * whole)) return unseen;
  if (right.size() == 1) return right[0] * right[0] / gram(0, 0);
  const double det = gram(0, 0) * gram(1, 1) - gram(0, 1) * gram(1, 0);
  if (!(det > 1e-6 * gram.trace() * gram.trace())) return unseen;
  return (right[0] * right[0] * gram(1, 1) - 2 * right[0] * right[1] * gram(0, 1) +
          right[1] * right[1] * gram(0, 0)) /
         det;
}

/// That noise alone gains as much with one or two columns.
double chance_of(double gain, Eigen::Index columns) {
  return columns == 1 ? std::erfc(std::sqrt(0.5 * gain)) : std::exp(-0.5 * gain);
}

/// What was seen of one carrier.
struct Look {
  Variation best;
  double chance = 1;    // of the best, by itself
  double constant = 0;  // gain of the carrier as it is everywhere
  std::size_t tests = 0;

  bool beats(const Look& other) const {
    // Far out all chances round to zero: the larger gain wins there.
    return chance < other.chance || (chance == other.chance && best.gain > other.best.gain);
  }
};

Look look_at(const Carrier& carrier, bool everything, const std::vector<Pattern>& patterns,
             const Eigen::VectorXd& left, const Whitening& whitening,
             const Eigen::MatrixXd& followed) {
  const Eigen::Index n = left.size();
  std::vector<const Pattern*> own;
  Eigen::Index columns = 1;
  for (const Pattern& p : patterns) {
    if (carrier.of_object && p.with->of_object) continue;
    if (p.often && !everything && carrier.stage != p.with->repeats_in) continue;
    own.push_back(&p);
    columns += p.factor.cols();
  }
  // The carrier itself, then what each pattern makes of it.
  Eigen::MatrixXd signature(n, columns);
  signature.col(0) = carrier.signature;
  Eigen::Index next = 1;
  for (const Pattern* p : own) {
    signature.middleCols(next, p->factor.cols()) = carrier.signature.asDiagonal() * p->factor;
    next += p->factor.cols();
  }
  signature = whitening.apply(signature);
  // Most show in few observations (in phase, or at low signal): the others cost nothing.
  std::vector<Eigen::Index> shown;
  for (Eigen::Index i = 0; i < n; ++i)
    if (signature(i, 0) != 0) shown.push_back(i);
  signature = Eigen::MatrixXd(signature(shown, Eigen::all));
  const Eigen::MatrixXd taken =
      Eigen::MatrixXd(followed(shown, Eigen::all)).transpose() * signature;
  const Eigen::VectorXd right = signature.transpose() * left(shown);
  const auto gain_at = [&](Eigen::Index first, Eigen::Index count) {
    const auto part = signature.middleCols(first, count);
    const auto lost = taken.middleCols(first, count);
    const Eigen::MatrixXd gram = part.transpose() * part - lost.transpose() * lost;
    return gain_of(gram, right.segment(first, count), part.squaredNorm());
  };

  Look look;
  look.constant = std::max(0.0, gain_at(0, 1));
  next = 1;
  for (const Pattern* p : own) {
    const Eigen::Index first = next, count = p->factor.cols();
    next += count;
    const auto part = signature.middleCols(first, count);
    const double whole = part.squaredNorm();
    // How many observations it rests on: the inverse of the sum of squared shares.
    const double fourth = part.array().square().square().sum();
    if (!(whole > 0) || whole * whole < fewest_carrying * fourth) continue;
    const double gain = gain_at(first, count);
    if (gain < 0) continue;
    ++look.tests;
    Look one;
    one.chance = chance_of(gain, count);
    one.best.gain = gain;
    if (!one.beats(look)) continue;
    look.chance = one.chance;
    Variation& best = look.best;
    best = {carrier.what, p->with->axis.name, p->with->axis.unit, p->kind, p->at, {}, gain, 1, {}};
    for (const auto& [value, said] : p->with->names)
      if (p->kind == Variation::Kind::level && p->at == value) best.at_name = said;
    best.signature = Eigen::MatrixXd::Zero(n, count);
    best.signature(shown, Eigen::all) = part;
  }
  return look;
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

  const Eigen::MatrixXd followed = followed_directions(fit).topRows(fit.residual.size());
  // Where a bound holds a parameter, it still pulls: that is no sign of anything else.
  const Eigen::VectorXd left = fit.residual - followed * (followed.transpose() * fit.residual);
  std::vector<Look> looks(carriers.size());
  for_each_index(carriers.size(), threads, [&](std::size_t k) {
    const bool everything = k + 1 == carriers.size();
    looks[k] = look_at(carriers[k], everything, patterns, left, whitening, followed);
  });
  std::size_t tests = 0;
  double known = 0;
  Look* strongest = &looks.front();
  for (Look& look : looks) {
    tests += look.tests;
    known = std::max(known, look.constant);
    if (look.beats(*strongest)) strongest = &look;
  }
  Variation variation = std::move(strongest->best);
  // What a known effect that is constant does as well, though not enough to be named, is no sign of
  // one that is not.
  const double chance = known > known_gain ? chance_of(std::max(0.0, variation.gain - known),
                                                       variation.signature.cols())
                                           : strongest->chance;
  variation.p_global = std::min(1.0, chance * static_cast<double>(tests));
  return variation;
}

}  // namespace umov::gap
