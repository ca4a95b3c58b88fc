#include <algorithm>
#include <cmath>
#include <functional>
#include <span>
#include <utility>

#include <fmt/format.h>

#include "host/gap/benchmark/proportion.hpp"
#include "host/gap/benchmark/score.hpp"
#include "host/gap/benchmark/seen.hpp"

namespace umov::gap::benchmark {
namespace {

constexpr int resamples = 1000;
constexpr std::size_t least_resampled = 10;
constexpr int calibration_resamples = 200;
constexpr int floor_draws = 100;
constexpr int bins = 10;
constexpr double least_listed_probability = 0.01;

Measure measure(std::string id, std::string title) {
  Measure m;
  m.id = std::move(id);
  m.title = std::move(title);
  return m;
}

using Condition = std::function<bool(const Seen&)>;

/// Share of the cases of `among` for which `hit` holds.
Measure share(std::string id, std::string title, const Cases& cases, const Condition& among,
              const Condition& hit) {
  Measure m = measure(std::move(id), std::move(title));
  std::size_t hits = 0;
  for (const Seen& c : cases) {
    if (!among(c)) continue;
    ++m.n;
    if (hit(c)) ++hits;
  }
  m.hits = hits;
  m.value = clopper_pearson(hits, m.n);
  return m;
}

/// Share of many trials a case may have.
Measure share_of_trials(std::string id, std::string title, const Cases& cases,
                        const std::function<std::vector<bool>(const Seen&)>& trials) {
  Measure m = measure(std::move(id), std::move(title));
  std::size_t hits = 0;
  for (const Seen& c : cases) {
    for (const bool hit : trials(c)) {
      ++m.n;
      if (hit) ++hits;
    }
  }
  m.hits = hits;
  m.value = clopper_pearson(hits, m.n);
  return m;
}

/// A statistic of numbers, one a case of `among`.
Measure statistic(std::string id, std::string title, const Cases& cases, const Condition& among,
                  const std::function<double(const Seen&)>& number,
                  const std::function<double(std::vector<double>)>& of, std::uint64_t seed) {
  std::vector<double> numbers;
  for (const Seen& c : cases) {
    if (!among(c)) continue;
    const double one = number(c);
    if (!std::isnan(one)) numbers.push_back(one);
  }
  Measure m = measure(std::move(id), std::move(title));
  m.n = numbers.size();
  m.value = bootstrap(
      numbers.size(),
      [&](std::span<const std::size_t> picks) {
        std::vector<double> picked;
        for (const std::size_t p : picks) picked.push_back(numbers[p]);
        return of(std::move(picked));
      },
      resamples, seed);
  return m;
}

double mean(const std::vector<double>& values) {
  double total = 0;
  for (const double v : values) total += v;
  return values.empty() ? std::numeric_limits<double>::quiet_NaN()
                        : total / static_cast<double>(values.size());
}

Measure micro_f1(std::string id, std::string title, const Cases& cases, const Condition& among,
                 std::uint64_t seed) {
  struct Counts {
    double right = 0, wrong = 0, missing = 0;
  };
  std::vector<Counts> all;
  for (const Seen& c : cases) {
    if (!among(c)) continue;
    const auto right = matched(names_of(*c.truth), c.last_claims);
    all.push_back({static_cast<double>(right),
                   static_cast<double>(wrongful(*c.truth, c.last_claims)),
                   static_cast<double>(c.truth->effects.size() - right)});
  }
  Measure m = measure(std::move(id), std::move(title));
  m.n = all.size();
  m.value = bootstrap(
      all.size(),
      [&](std::span<const std::size_t> picks) {
        Counts sum;
        for (const std::size_t p : picks) {
          sum.right += all[p].right;
          sum.wrong += all[p].wrong;
          sum.missing += all[p].missing;
        }
        const double whole = 2 * sum.right + sum.wrong + sum.missing;
        return whole > 0 ? 2 * sum.right / whole : std::numeric_limits<double>::quiet_NaN();
      },
      resamples, seed);
  return m;
}

Measure calibration(std::string id, std::string title, const Cases& cases, bool whole_catalogue,
                    std::uint64_t seed) {
  std::vector<std::vector<Forecast>> by_case;
  std::size_t n = 0;
  for (const Seen& c : cases) {
    std::vector<Forecast> own;
    const auto add = [&](const std::string& effect, double probability) {
      if (effect != model_cause) own.push_back({probability, c.truth->has(effect)});
    };
    if (whole_catalogue) {
      for (const auto& [effect, p] : c.first->probabilities)
        if (p >= least_listed_probability) add(effect, p);
    } else {
      for (const AnsweredCause& cause : c.first->causes) add(cause.effect, cause.probability);
    }
    n += own.size();
    if (!own.empty()) by_case.push_back(std::move(own));
  }
  Measure m = measure(std::move(id), std::move(title));
  m.n = n;
  m.value = bootstrap(
      by_case.size(),
      [&](std::span<const std::size_t> picks) {
        std::vector<Forecast> forecasts;
        for (const std::size_t p : picks)
          forecasts.insert(forecasts.end(), by_case[p].begin(), by_case[p].end());
        return std::max(0.0, calibration_error(forecasts, bins) -
                                 calibration_floor(forecasts, bins, floor_draws, seed + 1));
      },
      calibration_resamples, seed);
  return m;
}

/// For each claimed effect that is there: does the interval hold the true value? Of the principal
/// parameter, or of all.
std::vector<bool> intervals_hold(const Seen& c, bool principal_only) {
  std::vector<bool> held;
  for (const Claim& claim : c.claims) {
    for (const TrueEffect& e : c.truth->effects) {
      if (e.name != claim.lead) continue;
      const auto& known = c.first->cause(claim.lead)->parameters;
      for (std::size_t i = 0; i < (principal_only ? 1 : e.parameters.size()); ++i) {
        if (i >= e.parameters.size()) break;
        const auto found = known.find(e.parameters[i].first);
        if (found == known.end()) continue;
        const double truth = e.parameters[i].second;
        held.push_back(found->second.lo <= truth && truth <= found->second.hi);
      }
    }
  }
  return held;
}

double closed_against_oracle(const Seen& c) {
  const auto& oracle = c.entry->oracle;
  if (!oracle || !oracle->has_gap || !c.first->has_gap)
    return std::numeric_limits<double>::quiet_NaN();
  const double whole = oracle->g2_before - oracle->g2_after;
  return whole > 0 ? (c.first->g2_before - c.first->g2_after) / whole
                   : std::numeric_limits<double>::quiet_NaN();
}

Measure target(Measure m, double least, double most) {
  m.least = least;
  m.most = most;
  m.headline = true;
  return m;
}

Measure untold(Measure m) {
  m.oracle_has_it = false;
  return m;
}

constexpr double any = std::numeric_limits<double>::infinity();

}  // namespace

bool Measure::surely() const {
  if (std::isnan(value.lo) || std::isnan(value.hi)) return false;
  // A few cases resampled know nothing of those they lack.
  if (!hits && n < least_resampled) return false;
  if (met()) return value.lo >= least && value.hi <= most;
  return value.hi < least || value.lo > most;
}

std::vector<Measure> measures(const std::vector<Entry>& entries, Candidate candidate,
                              std::uint64_t seed) {
  const Cases cases = seen_by(entries, candidate);
  const auto single = [](double from, double to) {
    return [from, to](const Seen& c) {
      return c.is("single") && c.effect().rho >= from && c.effect().rho < to;
    };
  };
  const auto single_in_plane = [](const Seen& c) {
    return c.is("single") && c.effect().rho >= 10 && in_plane(*c.truth);
  };
  const auto up_to_set = [](const Seen& c) { return leads(c.claims, c.effect().name); };
  const auto plain = [](const Seen& c) {
    return !c.claims.empty() && c.claims.front().lead == c.effect().name;
  };
  const auto alarm = [](const Seen& c) { return alarmed(*c.truth, *c.first); };
  const auto flag = [](const Seen& c) { return c.first->flags_unknown(); };
  const auto none = [](const Seen& c) { return c.is("none"); };
  const auto known = [](const Seen& c) { return few_known(*c.truth); };
  const auto alone = [](const Seen& c) { return c.is("single") || c.is("confounded"); };
  const auto named = [alone](const Seen& c) {
    return alone(c) && !c.claims.empty() && !c.claims.front().is_model();
  };
  const auto unknown = [](const Seen& c) {
    return c.is("foreign") && c.truth->rho >= 8 && c.truth->look_alikes.empty();
  };
  const auto closable = [](const Seen& c) {
    return (few_known(*c.truth) || c.is("crowded")) && c.truth->rho >= 7;
  };
  const auto exact_after = [](const Seen& c) { return exact(*c.truth, c.last_claims); };
  const auto crowd = [](const Seen& c) { return c.is("crowded") && !c.truth->effects.empty(); };
  const auto median = [](std::vector<double> v) { return quantile(std::move(v), 0.5); };
  const auto decile = [](std::vector<double> v) { return quantile(std::move(v), 0.1); };

  std::vector<Measure> all;
  const auto add = [&](Measure m) { all.push_back(std::move(m)); };

  add(target(share("top1_set", "top-1, single effect, ρ ≥ 10, in plane, up to its ambiguity set",
                   cases, single_in_plane, up_to_set),
             .95, any));
  add(target(share("top1_plain", "plain top-1 of the same", cases, single_in_plane, plain), .85,
             any));
  add(target(
      share("top1_followed", "top-1 after at most two prescribed scans, ρ ≥ 10", cases,
            single(10, any), [](const Seen& c) { return leads(c.last_claims, c.effect().name); }),
      .95, any));
  add(target(share(
                 "detection", "detection, ρ ≥ 7", cases,
                 [known](const Seen& c) { return known(c) && c.truth->rho >= 7; }, alarm),
             .97, any));
  add(untold(
      target(share("false_alarms", "false alarms where there is no effect", cases, none, alarm),
             -any, .01)));
  add(target(share(
                 "exact_pair", "exact pair, both ρ ≥ 10, with the prescribed scans", cases,
                 [](const Seen& c) { return pair_of(c, 10, false); }, exact_after),
             .90, any));
  add(target(micro_f1(
                 "triples_f1", "triples, micro-F1, with the prescribed scans", cases,
                 [](const Seen& c) { return c.is("triple"); }, seed + 1),
             .85, any));
  add(untold(target(share("unknown_flagged", "unknown effect flagged, ρ ≥ 8 and not mimicked",
                          cases, unknown, flag),
                    .90, any)));
  add(untold(target(share("known_flagged", "known effects called unknown", cases, known, flag),
                    -any, .03)));
  add(untold(target(share("set_coverage", "ambiguity set holds the effect, where one is named",
                          cases, named, up_to_set),
                    .93, .97)));
  add(untold(
      target(statistic(
                 "set_size", "mean size of that set, ρ ≥ 10", cases,
                 [named](const Seen& c) { return named(c) && c.effect().rho >= 10; },
                 [](const Seen& c) { return static_cast<double>(c.claims.front().members.size()); },
                 mean, seed + 2),
             -any, 1.5)));
  add(untold(target(calibration("ece", "calibration error of the probabilities, floor subtracted",
                                cases, false, seed + 3),
                    -any, .03)));
  add(target(statistic("closed_median", "closed fraction against the oracle, median, ρ ≥ 7", cases,
                       closable, closed_against_oracle, median, seed + 5),
             .95, any));
  add(target(statistic("closed_decile", "closed fraction against the oracle, 10th percentile",
                       cases, closable, closed_against_oracle, decile, seed + 6),
             .80, any));
  add(target(share_of_trials(
                 "interval_coverage", "95 % interval holds the truth, principal parameters", cases,
                 [](const Seen& c) {
                   return few_known(*c.truth) ? intervals_hold(c, true) : std::vector<bool>{};
                 }),
             .92, .97));
  add(untold(
      target(share("crowded", "crowded bench: largest share is the enlarged effect, up to its set",
                   cases, crowd, [](const Seen& c) { return leads(c.claims, enlarged(c)); }),
             .90, any)));

  // What lies behind them.
  for (const auto& [from, to] : {std::pair{3., 5.}, {5., 10.}, {10., 20.}, {20., any}}) {
    const std::string band =
        to < any ? fmt::format("ρ {:g}–{:g}", from, to) : fmt::format("ρ ≥ {:g}", from);
    add(share(fmt::format("top1_set_from_{:g}", from), "single effect, up to its set, " + band,
              cases, single(from, to), up_to_set));
    add(share(fmt::format("top1_plain_from_{:g}", from), "single effect, plain, " + band, cases,
              single(from, to), plain));
  }
  add(share("single_exact", "single effect, ρ ≥ 10: it and nothing else claimed", cases,
            single(10, any), [](const Seen& c) { return exact(*c.truth, c.claims); }));
  add(share("detection_single", "detection, single effect, ρ ≥ 7", cases, single(7, any), alarm));
  add(share(
      "confounded_set", "confounded on purpose: set holds the effect", cases,
      [](const Seen& c) { return c.is("confounded"); }, up_to_set));
  add(untold(share("not_none_needed", "no effect: anything but `none_needed` (strict)", cases, none,
                   [](const Seen& c) { return c.first->verdict != "none_needed"; })));
  add(untold(share("false_names", "no effect: a cause is named", cases, none,
                   [](const Seen& c) { return wrongful(*c.truth, c.claims) > 0; })));
  add(untold(share(
      "false_alarms_one_lobe", "false alarms, one Gaussian lobe", cases,
      [none](const Seen& c) { return none(c) && c.truth->one_gaussian_lobe; }, alarm)));
  add(untold(share(
      "false_alarms_other", "false alarms, other materials", cases,
      [none](const Seen& c) { return none(c) && !c.truth->one_gaussian_lobe; }, alarm)));
  add(share(
      "exact_pair_apart", "exact pair, both ρ ≥ 10 beside the other, with prescribed scans", cases,
      [](const Seen& c) { return pair_of(c, 10, true); }, exact_after));
  add(share(
      "exact_pair_first", "exact pair, both ρ ≥ 10, own scan only", cases,
      [](const Seen& c) { return pair_of(c, 10, false); },
      [](const Seen& c) { return exact(*c.truth, c.claims); }));
  add(share(
      "exact_triple", "exact triple, with the prescribed scans", cases,
      [](const Seen& c) { return c.is("triple"); }, exact_after));
  add(share_of_trials("claims_right", "claims that are right, up to their set, few known effects",
                      cases, [known](const Seen& c) {
                        const std::size_t wrong = known(c) ? wrongful(*c.truth, c.claims) : 0;
                        const std::size_t right =
                            known(c) ? matched(names_of(*c.truth), c.claims) : 0;
                        std::vector<bool> trials(right + wrong, true);
                        std::fill_n(trials.begin(), wrong, false);
                        return trials;
                      }));
  add(untold(share("unknown_flagged_followed", "unknown effect flagged, after the prescribed scans",
                   cases, unknown, [](const Seen& c) { return c.last->flags_unknown(); })));
  add(untold(share("unknown_named", "unknown effect, ρ ≥ 8, not mimicked: taken for a known one",
                   cases, unknown,
                   [](const Seen& c) { return wrongful(*c.truth, c.claims) > 0; })));
  add(untold(share("known_unexplained", "known effects: verdict `unexplained`", cases, known,
                   [](const Seen& c) { return c.first->verdict == "unexplained"; })));
  add(untold(share(
      "set_coverage_10", "ambiguity set holds the effect, ρ ≥ 10", cases,
      [named](const Seen& c) { return named(c) && c.effect().rho >= 10; }, up_to_set)));
  add(untold(calibration("ece_all", "calibration error over all probabilities ≥ .01", cases, true,
                         seed + 7)));
  add(statistic(
      "closed_median_one_lobe", "closed fraction, median, one Gaussian lobe", cases,
      [closable](const Seen& c) { return closable(c) && c.truth->one_gaussian_lobe; },
      closed_against_oracle, median, seed + 9));
  add(statistic(
      "closed_decile_one_lobe", "closed fraction, 10th percentile, one Gaussian lobe", cases,
      [closable](const Seen& c) { return closable(c) && c.truth->one_gaussian_lobe; },
      closed_against_oracle, decile, seed + 10));
  add(statistic(
      "closed_median_any", "closed fraction, median, any ρ", cases,
      [](const Seen& c) { return few_known(*c.truth) || c.is("crowded"); }, closed_against_oracle,
      median, seed + 11));
  add(share_of_trials("interval_coverage_all", "95 % interval holds the truth, all parameters",
                      cases, [](const Seen& c) {
                        return few_known(*c.truth) ? intervals_hold(c, false) : std::vector<bool>{};
                      }));
  add(share_of_trials(
      "interval_coverage_crowded", "crowded: sizes of the named effects that are true", cases,
      [crowd](const Seen& c) { return crowd(c) ? intervals_hold(c, true) : std::vector<bool>{}; }));
  add(untold(share("crowded_alike",
                   "crowded: the enlarged effect or one that cannot be told from it", cases, crowd,
                   [](const Seen& c) {
                     const auto& alike = c.truth->look_alikes;
                     return leads(c.claims, enlarged(c)) ||
                            std::any_of(alike.begin(), alike.end(),
                                        [&](const auto& name) { return leads(c.claims, name); });
                   })));
  add(untold(share(
      "failed", "cases that could not be diagnosed", cases, [](const Seen&) { return true; },
      [](const Seen& c) { return c.first->verdict == "failed"; })));
  return all;
}

}  // namespace umov::gap::benchmark
