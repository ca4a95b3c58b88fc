#include "host/cli/study/real_data_page.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "host/cli/study/plots.hpp"

namespace umov::study {
namespace {

using Kind = Attempt::Kind;
constexpr double clear_of_noise = 0.1;

std::string share(double value) {
  return fmt::format("{:.{}f}", 100 * value, value < 0.1 ? 2 : 1);
}
std::string pair_of(const Score& s) {
  return s.points == 0 ? "none" : share(s.median) + " / " + share(s.p90);
}

std::vector<std::size_t> judged_where(const TrialPoints& points, auto&& keep) {
  std::vector<std::size_t> out;
  std::copy_if(points.judged.begin(), points.judged.end(), std::back_inserter(out), keep);
  return out;
}

void judge_matrices(const TrialPoints& points, const Attempt& attempt, Judged& out) {
  if (attempt.normalised.empty() || points.judged.empty()) return;
  double all = 0, linear = 0;
  for (const std::size_t i : points.judged) {
    for (std::size_t e = 1; e < 16; ++e) {
      const double d = attempt.normalised[i][e] - points.normalised[i][e];
      all += d * d;
      if (e / 4 < 3 && e % 4 < 3) linear += d * d;
    }
  }
  const auto n = static_cast<double>(points.judged.size());
  out.matrix_rms = std::sqrt(all / (15 * n));
  out.linear_rms = std::sqrt(linear / (8 * n));
}

/// What a perfect depolariser would leave: the measured elements themselves.
std::array<double, 2> elements_rms(const TrialPoints& points) {
  Attempt none;
  none.normalised.assign(points.size(), {});
  Judged out;
  judge_matrices(points, none, out);
  return {out.matrix_rms, out.linear_rms};
}

std::vector<std::size_t> in_order(const TrialResult& result) {
  std::vector<std::size_t> order(result.attempts.size());
  std::iota(order.begin(), order.end(), 0U);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    const bool fails_a = !result.attempts[a].failure.empty();
    const bool fails_b = !result.attempts[b].failure.empty();
    if (fails_a != fails_b) return fails_b;
    return result.judged[a].out_of_plane.median < result.judged[b].out_of_plane.median;
  });
  return order;
}

Json score_json(const Score& s) {
  return {{"points", s.points}, {"median", s.median}, {"p90", s.p90}, {"offset", s.offset}};
}

Json trial_json(const TrialResult& result) {
  Json list = Json::array();
  for (const std::size_t a : in_order(result)) {
    const Attempt& attempt = result.attempts[a];
    const Judged& j = result.judged[a];
    Json row = {{"name", attempt.name}, {"kind", kind_name(attempt.kind)}};
    if (!attempt.failure.empty()) {
      row["failure"] = attempt.failure;
    } else {
      row["parameters"] = attempt.parameters;
      row["in_plane_bic"] = attempt.in_plane_bic ? Json(*attempt.in_plane_bic) : Json(nullptr);
      row["in_plane"] = score_json(j.in_plane);
      row["out_of_plane"] = score_json(j.out_of_plane);
      row["clear_of_noise"] = score_json(j.clear);
      if (!attempt.with_remainder.empty()) row["with_remainder"] = score_json(j.with_remainder);
      if (!attempt.normalised.empty()) {
        row["matrix_rms"] = j.matrix_rms;
        row["linear_rms"] = j.linear_rms;
      }
    }
    list.push_back(std::move(row));
  }
  const auto& points = result.trial->points;
  return {{"in_plane_points", points.in_plane.size()},
          {"out_of_plane_points", points.judged.size()},
          {"noise", score_json(noise_score(points.relative_u, points.judged))},
          {"attempts", list}};
}

void add_main_table(Page& page, const TrialResult& result) {
  const auto& points = result.trial->points;
  std::vector<std::vector<std::string>> rows;
  const std::size_t chosen = result.chosen();
  for (const std::size_t a : in_order(result)) {
    const Attempt& attempt = result.attempts[a];
    const Judged& j = result.judged[a];
    const std::string name =
        attempt.kind == Kind::interpolation ? attempt.name : "`" + attempt.name + "`";
    if (!attempt.failure.empty()) {
      rows.push_back({name, kind_name(attempt.kind), attempt.failure, "", "", "", "", ""});
      continue;
    }
    rows.push_back({(a == chosen ? "**chosen** " : "") + name, kind_name(attempt.kind),
                    attempt.parameters == 0 ? "" : std::to_string(attempt.parameters),
                    attempt.in_plane_bic ? fmt::format("{:.0f}", *attempt.in_plane_bic) : "",
                    pair_of(j.in_plane), pair_of(j.out_of_plane), pair_of(j.clear),
                    attempt.with_remainder.empty() ? "" : pair_of(j.with_remainder)});
  }
  const auto clear =
      judged_where(points, [&](std::size_t i) { return points.relative_u[i] < clear_of_noise; });
  rows.push_back({"the data's own noise", "", "", "", "",
                  pair_of(noise_score(points.relative_u, points.judged)),
                  pair_of(noise_score(points.relative_u, clear)), ""});
  page.table({"model or interpolation", "kind", "free", "BIC in plane", "in plane, %",
              "out of plane, %", "clear of noise, %", "with remainder, %"},
             std::move(rows));
}

void add_regions(Page& page, const TrialResult& result) {
  const auto& points = result.trial->points;
  std::vector<std::string> header = {"median / 90th percentile, %"};
  std::array<std::vector<std::size_t>, region_names.size()> at;
  for (std::size_t r = 0; r < at.size(); ++r) {
    at[r] = judged_where(points, [&](std::size_t i) {
      return region_of(points.direction[i]) == static_cast<Region>(r);
    });
    header.push_back(fmt::format("{} ({})", region_names[r], at[r].size()));
  }
  std::vector<std::vector<std::string>> rows;
  std::vector<std::size_t> shown = {result.chosen(), result.best({Kind::several}),
                                    result.best({Kind::one_lobe}),
                                    result.best({Kind::interpolation})};
  for (std::size_t n = 0; n < shown.size(); ++n) {
    if (shown[n] >= result.attempts.size() ||
        std::find(shown.begin(), shown.begin() + static_cast<std::ptrdiff_t>(n), shown[n]) !=
            shown.begin() + static_cast<std::ptrdiff_t>(n))
      continue;
    std::vector<std::string> row = {result.attempts[shown[n]].name};
    for (const Score& s : result.judged[shown[n]].regions)
      row.push_back(s.points == 0 ? "none"
                                  : fmt::format("{} (offset {:+.1f})", pair_of(s), 100 * s.offset));
    rows.push_back(std::move(row));
  }
  std::vector<std::string> noise = {"the data's own noise"};
  for (const auto& list : at) noise.push_back(pair_of(noise_score(points.relative_u, list)));
  rows.push_back(std::move(noise));
  page.table(std::move(header), std::move(rows));
}

/// Which region has most left to explain by the model that the in-plane rows choose.
void add_worst_region(Page& page, const TrialResult& result) {
  const std::size_t chosen = result.chosen();
  if (chosen == result.attempts.size()) return;
  const auto& points = result.trial->points;
  double worst = 0;
  std::string sentence;
  for (std::size_t r = 0; r < region_names.size(); ++r) {
    const Score& s = result.judged[chosen].regions[r];
    const Score noise =
        noise_score(points.relative_u, judged_where(points, [&](std::size_t i) {
                      return region_of(points.direction[i]) == static_cast<Region>(r);
                    }));
    if (s.points == 0 || !(noise.median > 0) || s.median / noise.median <= worst) continue;
    worst = s.median / noise.median;
    sentence = fmt::format(
        "The chosen model is farthest from the noise here: {}, median {} % where noise alone gives "
        "{} %, {} by {} % in the middle.",
        region_names[r], share(s.median), share(noise.median),
        s.offset < 0 ? "too low" : "too high", share(std::abs(s.offset)));
  }
  page.paragraph(sentence);
}

void add_matrices(Page& page, const TrialResult& result) {
  std::vector<std::vector<std::string>> rows;
  for (const std::size_t a : in_order(result)) {
    const Judged& j = result.judged[a];
    if (j.matrix_rms == 0 || !result.attempts[a].failure.empty()) continue;
    rows.push_back({result.attempts[a].name, fmt::format("{:.4f}", j.linear_rms),
                    fmt::format("{:.4f}", j.matrix_rms)});
  }
  if (rows.empty()) return;
  std::stable_sort(rows.begin(), rows.end(),
                   [](const auto& a, const auto& b) { return a[1] < b[1]; });
  const auto none = elements_rms(result.trial->points);
  rows.push_back(
      {"no polarisation at all", fmt::format("{:.4f}", none[1]), fmt::format("{:.4f}", none[0])});
  page.paragraph(
      "Mueller elements out of the plane, root mean square error of m_ij/f11. Fitted are the four "
      "states PP, PS, SP, SS in plane, as the reflectometer measures them, so that nothing was "
      "said "
      "to the fit of U and V. The interpolation takes all sixteen measured elements in plane, in "
      "the "
      "basis of the scattering plane, and turns them.");
  page.table({"", "the 8 linear elements", "all 15"}, std::move(rows));
}

void add_error_figure(Page& page, const TrialResult& result, const std::string& name,
                      bool by_wavelength) {
  const auto& points = result.trial->points;
  std::map<double, std::vector<std::size_t>> bins;
  for (const std::size_t i : points.judged) {
    const double bin = by_wavelength ? points.wavelength_nm[i]
                                     : 5 + 10 * std::floor(points.direction[i].difference_deg / 10);
    bins[bin].push_back(i);
  }
  std::vector<double> x, noise;
  for (const auto& [bin, list] : bins) {
    x.push_back(bin);
    noise.push_back(100 * noise_score(points.relative_u, list).median);
  }
  Json data = Json::array();
  const auto add = [&](const std::vector<double>& foretold, const std::string& title,
                       const char* colour, const char* dash) {
    std::vector<double> y;
    for (const auto& [bin, list] : bins)
      y.push_back(100 * score(foretold, points.brdf_per_sr, list).median);
    data.push_back(line(title, x, y, colour, dash));
  };
  const auto add_best = [&](Kind kind, const char* colour) {
    const std::size_t a = result.best({kind});
    if (a < result.attempts.size())
      add(result.attempts[a].foretold, result.attempts[a].name, colour, "solid");
  };
  add_best(Kind::several, "#1f5fbf");
  add_best(Kind::one_lobe, "#d4331d");
  add_best(Kind::interpolation, "#16883a");
  const std::size_t both = result.best({Kind::several, Kind::one_lobe, Kind::no_lobe}, true);
  if (both < result.attempts.size())
    add(result.attempts[both].with_remainder, result.attempts[both].name + " with remainder",
        "#74296f", "dash");
  data.push_back(line("noise", x, noise, "#5a6472", "dot"));
  Json layout = axes(by_wavelength ? "wavelength, nm" : "difference angle θd, deg",
                     "median error out of plane, %", true);
  page.figure(
      name,
      fmt::format("{}: size of the relative error out of plane by {}; the best model of each "
                  "kind, the best interpolation.",
                  result.trial->name, by_wavelength ? "wavelength" : "difference angle"),
      std::move(data), std::move(layout));
}

std::string at_best(const TrialResult& result, std::size_t a, bool with_remainder = false) {
  if (a >= result.attempts.size()) return "none";
  const Judged& j = result.judged[a];
  return fmt::format("{} % ({}{})",
                     share((with_remainder ? j.with_remainder : j.out_of_plane).median),
                     result.attempts[a].name, with_remainder ? " with remainder" : "");
}

void add_targets(const TrialResult& result, std::vector<Target>& targets) {
  const std::size_t none = result.attempts.size();
  const std::size_t chosen = result.chosen();
  if (chosen == none) return;
  const double ours = result.judged[chosen].out_of_plane.median;
  const auto against = [&](std::size_t rival, const char* what) {
    if (rival == none || rival == chosen) return;
    targets.push_back({fmt::format("{}: the model chosen in plane against {}, median out of plane",
                                   result.trial->name, what),
                       "< " + at_best(result, rival), at_best(result, chosen),
                       ours < result.judged[rival].out_of_plane.median});
  };
  against(result.best({Kind::one_lobe}), "the best model of one lobe");
  against(result.best({Kind::interpolation}), "the best interpolation");
}

void add_trial(Page& page, const TrialResult& result, std::vector<Target>& targets) {
  const auto& trial = *result.trial;
  const auto& points = trial.points;
  const std::string slug = trial.name.substr(trial.name.find(' ') + 1);
  page.heading(trial.name);
  std::string scatter;
  if (!trial.scatter_per_sr.empty()) {
    std::vector<double> list;
    for (const auto& [nm, value] : trial.scatter_per_sr) list.push_back(value);
    const auto [low, high] = std::minmax_element(list.begin(), list.end());
    scatter = fmt::format(
        " Far from the lobe (θh > 25°) in-plane points scatter about the plane through their "
        "neighbours by {:.4f} to {:.4f}/sr, by wavelength; both ways of the light stand side by "
        "side "
        "there, so a failure of reciprocity is part of it, and what a plane cannot follow: it is "
        "rather "
        "too large. It joins the 2.5 % of the value in the "
        "weights of the fit and in what is called noise.",
        *low, *high);
  }
  page.paragraph(fmt::format("{} points in plane, {} out of it.{}", points.in_plane.size(),
                             points.judged.size(), scatter));
  add_main_table(page, result);
  page.paragraph(fmt::format(
      "Best of several lobes: {}. Best of one lobe: {}. Best interpolation: {}. Best model with "
      "its "
      "remainder interpolated: {}. In-plane rows alone would choose: {}.",
      at_best(result, result.best({Kind::several})), at_best(result, result.best({Kind::one_lobe})),
      at_best(result, result.best({Kind::interpolation})),
      at_best(result, result.best({Kind::several, Kind::one_lobe, Kind::no_lobe}, true), true),
      at_best(result, result.chosen())));
  page.paragraph(
      "Where the misses are, by region (number of points); the offset is the median with "
      "sign, foretold less measured:");
  add_regions(page, result);
  add_worst_region(page, result);
  if (!points.normalised.empty()) add_matrices(page, result);
  add_error_figure(page, result, slug + "-angle", false);
  if (!trial.alone.empty()) add_error_figure(page, result, slug + "-wavelength", true);
  add_targets(result, targets);
  page.numbers()["samples"][trial.name] = trial_json(result);
}

void introduce(Page& page, const std::vector<std::string>& skipped) {
  page.paragraph(
      "Models of the library are fitted to the in-plane rows of measurements that other people "
      "made, "
      "and foretell every direction out of the plane, which they have not seen. Sintered PTFE: "
      "full "
      "Mueller matrices (T. A. Germer, Applied Optics 2017, NIST). Garnet red and krylon blue: "
      "unpolarised spectra of two paints (Cornell Program of Computer Graphics), 31 wavelengths.");
  if (!skipped.empty())
    page.paragraph(
        fmt::format("**Skipped**, the data were not there: {}.", fmt::join(skipped, ", ")));
  page.paragraph(
      "**Fits.** PTFE: one joint fit of all wavelengths. Paints: one joint fit of five wavelengths "
      "(410, 480 … 690 nm) gives the parameters that wavelengths share (index, widths); with those "
      "held, every wavelength is fitted alone. Robust least squares, six starts, no tuning on rows "
      "out of the plane. **Chosen** is the model with the least N ln s² + k ln N in plane (s the "
      "scale "
      "of the residuals, k the free numbers of the joint fit).");
  page.paragraph(
      "**Rivals without a model**, from the same rows, in logarithms: in half and difference angle "
      "(θh, θd) the mean of the four nearest points weighted by 1/distance², as `umov invert "
      "--compare interpolation`, and a local plane through eight of them; in plain angles the "
      "curve "
      "of the incidence over the angle to the mirror direction, both sides together. **With "
      "remainder**: the model times measured/fitted in plane, interpolated as a local plane.");
  page.paragraph(
      "Errors are sizes of foretold/measured − 1, median / 90th percentile. Normal incidence, "
      "where "
      "no plane is out of plane, is not judged, nor are values clipped to zero. **Clear of noise** "
      "are points whose "
      "uncertainty is below 10 %. The last row is what a perfect model would score against data of "
      "that noise.");
}

}  // namespace

std::size_t TrialResult::best(const std::vector<Kind>& kinds, bool with_remainder) const {
  std::size_t found = attempts.size();
  const auto median = [&](std::size_t a) {
    return (with_remainder ? judged[a].with_remainder : judged[a].out_of_plane).median;
  };
  for (std::size_t a = 0; a < attempts.size(); ++a) {
    if (!attempts[a].failure.empty() ||
        std::find(kinds.begin(), kinds.end(), attempts[a].kind) == kinds.end())
      continue;
    if (found == attempts.size() || median(a) < median(found)) found = a;
  }
  return found;
}

std::size_t TrialResult::chosen() const {
  std::size_t found = attempts.size();
  for (std::size_t a = 0; a < attempts.size(); ++a) {
    if (!attempts[a].failure.empty() || !attempts[a].in_plane_bic) continue;
    if (found == attempts.size() || *attempts[a].in_plane_bic < *attempts[found].in_plane_bic)
      found = a;
  }
  return found;
}

void judge(TrialResult& result) {
  const auto& points = result.trial->points;
  const auto& measured = points.brdf_per_sr;
  const auto clear =
      judged_where(points, [&](std::size_t i) { return points.relative_u[i] < clear_of_noise; });
  result.judged.clear();
  for (const Attempt& attempt : result.attempts) {
    Judged& out = result.judged.emplace_back();
    if (!attempt.failure.empty()) continue;
    out.in_plane = score(attempt.foretold, measured, points.in_plane);
    out.out_of_plane = score(attempt.foretold, measured, points.judged);
    out.clear = score(attempt.foretold, measured, clear);
    if (!attempt.with_remainder.empty())
      out.with_remainder = score(attempt.with_remainder, measured, points.judged);
    for (std::size_t r = 0; r < out.regions.size(); ++r)
      out.regions[r] = score(attempt.foretold, measured, judged_where(points, [&](std::size_t i) {
                               return region_of(points.direction[i]) == static_cast<Region>(r);
                             }));
    judge_matrices(points, attempt, out);
  }
}

Page real_data_page(const std::vector<TrialResult>& results,
                    const std::vector<std::string>& skipped, const Options& options) {
  Page page("real-data", "Real data: from the plane of incidence to the hemisphere");
  introduce(page, skipped);
  page.numbers()["skipped"] = skipped;
  page.numbers()["seed"] = options.seed;
  std::vector<Target> targets;
  for (const TrialResult& result : results) add_trial(page, result, targets);
  page.heading("In sum");
  page.targets(std::move(targets));
  page.paragraph(fmt::format("Command `{}`, seed {}.", options.command, options.seed));
  return page;
}

}  // namespace umov::study
