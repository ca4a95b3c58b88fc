#include "host/gap/engine/excess_variance.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

namespace umov::gap {
namespace {

constexpr double smallest_size = 1e-5, largest_size = 0.5;
/// Odds of noise that is new in every observation and yet unseen within one, against the effect. A
/// source's noise is seen within an observation or slow; this kind needs something that changes at
/// every move.
constexpr double odds_of_fresh = 1.0 / 3.0;
/// Noise that forgets faster than this from one observation to the next is not slow but fresh.
constexpr double least_memory = 0.5;
/// ln of the density below its maximum beyond which nothing counts.
constexpr double depth = 12;

double ln_sum(double a, double b) {
  const double most = std::max(a, b);
  return most + std::log(std::exp(a - most) + std::exp(b - most));
}

/// ln-likelihood of the leftover as a function of what is fresh and what is fixed to places.
class Likelihood {
 public:
  Likelihood(const NoiseShape& shape, const Leftover& leftover, const RelativeNoise& learned)
      : shape_(shape), leftover_(leftover) {
    // What fits took is not there to count twice: of so many observations as many are independent
    // as there were less the parameters, here weighed by what each says of the scatter.
    double all = 0, kept = 0;
    for (Eigen::Index i = 0; i < shape.sigma.size(); ++i) {
      const double weight = std::pow(shape.relative[i] / shape.sigma[i], 4);
      all += weight;
      kept += weight * leftover.kept[i];
    }
    if (all > 0) independent_ = kept / all;
    // The slow part as it is beside the excess, and as it is where it must stand in for it.
    slow_.push_back({});
    if (learned.slow > 0) slow_.push_back({0, learned.slow, learned.memory});
    for (const double size : {3e-4, 1e-3, 3e-3, 1e-2})
      for (const double memory : {0.6, 0.9}) stand_ins_.push_back({0, size, memory});
  }

  double at(double fresh, double fixed) const {
    double best = -1e300;
    for (RelativeNoise n : slow_) {
      n.white = fresh;
      n.pattern = fixed;
      best = std::max(best, of(n));
    }
    return best;
  }

  /// Without either; the slow part does what it can.
  RelativeNoise without(double& value) const {
    RelativeNoise best;
    value = of(best);
    const auto consider = [&](const RelativeNoise& n) {
      const double l = of(n);
      if (l <= value) return false;
      value = l;
      best = n;
      return true;
    };
    for (const RelativeNoise& n : slow_) consider(n);
    for (const RelativeNoise& n : stand_ins_) consider(n);
    for (double step = 0.5; best.slow > 0 && step > 0.02;) {
      bool moved = false;
      for (const double sign : {1.0, -1.0}) {
        RelativeNoise n = best;
        n.slow *= std::exp(sign * step);
        moved = consider(n) || moved;
        n = best;
        n.memory = 1 - (1 - n.memory) * std::exp(sign * step);
        if (n.memory >= least_memory && n.memory < 0.9999) moved = consider(n) || moved;
      }
      if (!moved) step *= 0.5;
    }
    return best;
  }

  RelativeNoise noise_at(double fresh, double fixed) const {
    RelativeNoise best;
    double most = -1e300;
    for (RelativeNoise n : slow_) {
      n.white = fresh;
      n.pattern = fixed;
      if (const double l = of(n); l > most) {
        most = l;
        best = n;
      }
    }
    return best;
  }

 private:
  double of(const RelativeNoise& n) const {
    constexpr double price_of_slow = 6;  // as in learning: its size and memory were looked for
    return -0.5 * independent_ *
               misfit(shape_, leftover_.residual, leftover_.kept, n, leftover_.noise_scale) -
           (n.slow > 0 ? price_of_slow : 0.0);
  }

  const NoiseShape& shape_;
  const Leftover& leftover_;
  double independent_ = 1;  ///< share of the observations
  std::vector<RelativeNoise> slow_, stand_ins_;
};

/// A function of the logarithm of a size about its maximum.
struct Peak {
  double at = 0;          ///< ln of the size
  double value = -1e300;  ///< there
  double from = 0, to = 0;
};

Peak peak_of(const std::function<double(double)>& f) {
  const double first = std::log(smallest_size), last = std::log(largest_size);
  Peak peak;
  constexpr int coarse = 44;
  const double step = (last - first) / coarse;
  std::vector<double> seen;
  for (int k = 0; k <= coarse; ++k) {
    seen.push_back(f(first + k * step));
    if (seen.back() > peak.value) {
      peak.value = seen.back();
      peak.at = first + k * step;
    }
  }
  for (double fine = 0.5 * step; fine > 1e-3; fine *= 0.5) {
    for (const double sign : {1.0, -1.0}) {
      const double x = std::clamp(peak.at + sign * fine, first, last);
      if (const double v = f(x); v > peak.value) {
        peak.value = v;
        peak.at = x;
        break;
      }
    }
  }
  const auto edge = [&](double towards) {
    double inside = peak.at, outside = towards;
    if (f(outside) > peak.value - depth) return outside;
    for (int k = 0; k < 14; ++k) {
      const double middle = 0.5 * (inside + outside);
      (f(middle) > peak.value - depth ? inside : outside) = middle;
    }
    return outside;
  };
  peak.from = edge(first);
  peak.to = edge(last);
  return peak;
}

/// ln of the density of a size in terms of its logarithm: half of Cauchy's, for sizes of scatter
/// spread over decades.
double ln_prior(double ln_size, double usual) {
  const double ratio = std::exp(ln_size) / usual;
  return std::log(2 / std::numbers::pi) - std::log(usual) - std::log1p(ratio * ratio) + ln_size;
}

/// ln ∫ exp f over the logarithm of the size.
double ln_integral(const std::function<double(double)>& f, const Peak& peak, int points) {
  const double step = (peak.to - peak.from) / points;
  double sum = 0;
  for (int k = 0; k < points; ++k) sum += std::exp(f(peak.from + (k + 0.5) * step) - peak.value);
  return peak.value + std::log(std::max(sum * step, 1e-300));
}

/// The largest size below (or smallest above) the best at which `f` has fallen by 1.92.
double bound_of(const std::function<double(double)>& f, double best, double most, bool above) {
  constexpr double fall = 1.920729;
  double inside = best, outside = above ? std::log(largest_size) : std::log(smallest_size);
  if (f(outside) > most - fall) return above ? largest_size : 0.0;
  for (int k = 0; k < 24; ++k) {
    const double middle = 0.5 * (inside + outside);
    (f(middle) > most - fall ? inside : outside) = middle;
  }
  return std::exp(outside);
}

/// One comparison of an observation with its neighbours along the row.
struct Comparison {
  double square = 0;  ///< of the difference from a parabola's continuation, over the signal
  double noise = 0;   ///< variance of that by the known noise
};

std::vector<Comparison> compare_neighbours(const ForwardModel& model, const NoiseShape& shape,
                                           const Leftover& leftover) {
  // Third differences of unit length: blind to anything that a parabola follows.
  constexpr std::array<double, 4> weight{0.2236068, -0.6708204, 0.6708204, -0.2236068};
  const std::vector<int>& row = model.observations().row;
  std::vector<Comparison> all;
  for (std::size_t k = 0; k + weight.size() <= shape.order.size(); ++k) {
    if (row[static_cast<std::size_t>(shape.order[k])] !=
        row[static_cast<std::size_t>(shape.order[k + weight.size() - 1])])
      continue;
    double difference = 0, noise = 0;
    bool lit = true;
    for (std::size_t j = 0; j < weight.size(); ++j) {
      const Eigen::Index i = shape.order[k + j];
      const double s = shape.relative[i];
      lit = lit && s != 0;
      if (!lit) break;
      difference += weight[j] * leftover.residual[i] / (s * std::sqrt(leftover.kept[i]));
      const double known = weight[j] * leftover.noise_scale * shape.sigma[i] / s;
      noise += known * known;
    }
    if (lit) all.push_back({difference * difference, noise});
  }
  return all;
}

/// Variance beyond the known noise that makes the comparisons as large as squares of normal numbers
/// are, those beyond 1.5 standard deviations counted as 1.5: a region of bad ones moves it little.
void ask_neighbours(const std::vector<Comparison>& all, double expected, ExcessVariance& found) {
  constexpr double cut = 2.25, mean_when_cut = 0.7784;
  // Of squares that are cut, one degree of freedom each, and of differences that share
  // observations.
  constexpr double efficiency = 0.725, independent = 0.43;
  std::vector<double> weight;
  double sum = 0, squares = 0, unit = 0;
  for (const Comparison& c : all) {
    const double share = expected / (c.noise + expected);
    weight.push_back(share * share);
    sum += weight.back();
    squares += weight.back() * weight.back();
    unit += weight.back() * (c.noise + expected);
  }
  if (!(sum > 0)) return;
  const auto too_small = [&](double v) {
    double mean = 0;
    for (std::size_t k = 0; k < all.size(); ++k)
      mean += weight[k] * std::min(cut, all[k].square / (all[k].noise + v));
    return mean > mean_when_cut * sum;
  };
  double lo = 0, hi = expected;
  if (!too_small(0)) {
    hi = 0;
  } else {
    while (too_small(hi) && hi < 1) hi *= 2;
    for (int k = 0; k < 40; ++k) {
      const double middle = 0.5 * (lo + hi);
      (too_small(middle) ? lo : hi) = middle;
    }
  }
  found.local = hi;
  const double count = sum * sum / squares;
  found.local_u = unit / sum * std::sqrt(2 / (efficiency * independent * count));
}

}  // namespace

double ExcessVariance::joint_probability() const {
  return std::min(1.0, probability + fresh_probability);
}

bool ExcessVariance::ambiguous(double within) const {
  return 2 * std::abs(std::log(std::max(probability, 1e-300)) -
                      std::log(std::max(fresh_probability, 1e-300))) <
         within;
}

bool ExcessVariance::confirmed() const {
  constexpr double seen = 2, same = 3;  // standard errors
  return local > seen * local_u && local > size * size - same * local_u;
}

ExcessVariance weigh_excess(const ForwardModel& model, const Effect& effect,
                            const NoiseShape& shape, const Leftover& leftover,
                            const RelativeNoise& learned, double ln_odds) {
  ExcessVariance found;
  if (shape.relative.size() == 0) return found;
  const bool repeats = !shape.same_place.empty();
  const bool known = model.noise_is_known();
  const double usual = effect.parameters.front().prior_u;
  const Likelihood likelihood(shape, leftover, learned);
  const auto density = [&](bool fixed) {
    return [&, fixed](double ln_size) {
      const double size = std::exp(ln_size);
      return likelihood.at(fixed ? 0 : size, fixed ? size : 0) + ln_prior(ln_size, usual);
    };
  };
  constexpr int points = 48;
  const Peak fixed_peak = peak_of(density(true));
  const double ln_fixed = ln_integral(density(true), fixed_peak, points);
  const Peak fresh_peak = repeats ? peak_of(density(false)) : fixed_peak;
  const double ln_fresh = repeats ? ln_integral(density(false), fresh_peak, points) : ln_fixed;

  // Both: by their common size and what part of it is which.
  double ln_both = -1e300, both_fresh = 0, both_fixed = 0;
  if (repeats) {
    constexpr int angles = 12, radii = 24;
    const double from = std::min(fixed_peak.from, fresh_peak.from);
    const double to = std::max(fixed_peak.to, fresh_peak.to) + 0.1;
    const double step = (to - from) / radii, turn = 0.5 * std::numbers::pi / angles;
    double most = -1e300;
    for (int a = 0; a < angles; ++a) {
      const double angle = (a + 0.5) * turn;
      for (int k = 0; k < radii; ++k) {
        const double ln_size = from + (k + 0.5) * step;
        const double fresh = std::exp(ln_size) * std::cos(angle);
        const double fixed = std::exp(ln_size) * std::sin(angle);
        const double value = likelihood.at(fresh, fixed) + ln_prior(std::log(fresh), usual) +
                             ln_prior(std::log(fixed), usual) -
                             std::log(std::cos(angle) * std::sin(angle));
        ln_both = ln_sum(ln_both, value + std::log(step * turn));
        if (value > most) {
          most = value;
          both_fresh = fresh;
          both_fixed = fixed;
        }
      }
    }
  }

  double ln_neither = 0;
  found.without = likelihood.without(ln_neither);
  if (shape.doubt > 0) {
    // The known noise may itself be larger than it says.
    double sum = 0;
    const double step = 0.25;
    const double none = likelihood.at(0, 0);
    double most = none;
    std::vector<double> value;
    for (double t = 0.5 * step; t < 6; t += step) {
      value.push_back(likelihood.at(std::sqrt(t * shape.doubt), 0) - 0.5 * t * t);
      most = std::max(most, value.back());
    }
    for (const double v : value) sum += std::exp(v - most);
    ln_neither =
        std::max(ln_neither, most + std::log(sum * step * std::sqrt(2 / std::numbers::pi)));
  }
  const double ln_fresh_odds = ln_odds + std::log(odds_of_fresh);
  // Noise that is known up to a factor is fresh noise to begin with.
  const double only_fixed = ln_odds + ln_fixed;
  const double only_fresh = (known ? ln_fresh_odds : 0.0) + ln_fresh;
  const double both = ln_odds + (known ? ln_fresh_odds : 0.0) + ln_both;
  const double neither = known ? ln_neither : -1e300;
  const double all = ln_sum(ln_sum(only_fixed, only_fresh), ln_sum(both, neither));
  found.probability = std::exp(only_fixed - all) + std::exp(both - all);
  found.fresh_probability = std::exp(only_fresh - all) + std::exp(both - all);

  // Its size, the fresh noise refitted where that is believed beside it.
  const bool beside = both > only_fixed;
  const auto profile = [&](double ln_size) {
    const double size = std::exp(ln_size);
    double best = likelihood.at(0, size);
    if (beside)
      for (double ratio = 0.25; ratio < 3; ratio *= 1.2)
        best = std::max(best, likelihood.at(ratio * both_fresh, size));
    return best;
  };
  double best = beside ? std::log(both_fixed) : fixed_peak.at, most = profile(best);
  for (double fine = 0.1; fine > 1e-3; fine *= 0.5) {
    for (const double sign : {1.0, -1.0}) {
      if (const double v = profile(best + sign * fine); v > most) {
        most = v;
        best += sign * fine;
        break;
      }
    }
  }
  found.size = std::exp(best);
  found.lo = bound_of(profile, best, most, false);
  found.hi = bound_of(profile, best, most, true);
  found.with = likelihood.noise_at(beside ? both_fresh : 0, found.size);

  ask_neighbours(compare_neighbours(model, shape, leftover), found.size * found.size, found);
  return found;
}

}  // namespace umov::gap
