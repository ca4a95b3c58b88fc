#include "host/invert/search.hpp"

#include <algorithm>
#include <cmath>
#include <mutex>

#include "host/invert/descent.hpp"
#include "host/invert/starts.hpp"
#include "host/invert/stopwatch.hpp"
#include "host/parallel/for_each_index.hpp"

namespace umov::invert {
namespace {

/// Geometries of each scan that the starting stage looks at, and the share of the BRDF by which the
/// model may be off there: enough to smooth the way to the optimum.
constexpr std::size_t sites_per_scan = 20;
constexpr double starting_floor = 0.03;
/// Distinct candidates that are followed to the end.
constexpr std::size_t finalists = 2;
/// Points of the same quality to this share have reached the same optimum.
constexpr double same_optimum = 1e-3;

}  // namespace

Observations starting_observations(const Observations& data) {
  return thinned(data, sites_per_scan, starting_floor);
}

Found search(const Layout& layout, const Observations& data, const Priors& priors,
             const Options& options) {
  const auto report = [&](double share, const char* stage) {
    if (options.progress) options.progress(share, stage);
  };
  Stopwatch clock;
  Found out;
  const Observations thin = starting_observations(data);
  const Descent descent({layout, data, priors, {}});
  const std::vector<bool>& linear = descent.linear();
  report(0, "starting values");
  const auto starts = starting_points(layout, thin, lobe_slope(data), options.starts, options.seed,
                                      options.threads);
  out.phase_seconds.emplace_back("starting values", clock.lap());

  struct Tried {
    RobustSolution robust;
    double merit = 0;
  };
  std::vector<Tried> tried(starts.size());
  const auto try_from = [&](const std::vector<double>& x) {
    Tried one{robust_least_squares(layout, thin, priors, x, {}, linear, 4, 60), 0};
    one.merit = measured_scale(layout, thin, one.robust.solution, 4);
    return one;
  };
  std::mutex reporting;
  std::size_t done = 0;
  for_each_index(starts.size(), options.threads, [&](std::size_t i) {
    tried[i] = try_from(starts[i]);
    const std::lock_guard lock(reporting);
    ++done;
    report(0.1 + 0.4 * static_cast<double>(done) / static_cast<double>(starts.size()), "starts");
  });
  const auto by_merit = [](const Tried& a, const Tried& b) { return a.merit < b.merit; };
  std::stable_sort(tried.begin(), tried.end(), by_merit);
  out.starts = starts.size();
  for (const Tried& one : tried) {
    if (one.merit <= tried.front().merit * (1 + same_optimum)) ++out.agreeing;
  }
  // A better basin along a line that no start happened to lie in?
  std::vector<double> beyond = tried.front().robust.solution.x;
  if (descent.search_lines(beyond)) tried.push_back(try_from(beyond));
  std::stable_sort(tried.begin(), tried.end(), by_merit);
  out.phase_seconds.emplace_back("starts", clock.lap());

  std::vector<std::size_t> followed;
  for (std::size_t i = 0; i < tried.size() && followed.size() < finalists; ++i) {
    const bool new_optimum =
        followed.empty() || tried[i].merit > tried[followed.back()].merit * (1 + same_optimum);
    // The first in any case: its merit may be zero.
    if (followed.empty() || (new_optimum && tried[i].merit < 1.5 * tried.front().merit))
      followed.push_back(i);
  }

  report(0.5, "all points");
  const bool paper = options.objective == Objective::paper;
  const std::vector<double> no_factor(paper ? 0 : data.factor_names.size(), 0.0);
  std::vector<RobustSolution> ended(followed.size());
  std::vector<double> quality(followed.size());
  for_each_index(followed.size(), options.threads, [&](std::size_t i) {
    const std::vector<double>& x = tried[followed[i]].robust.solution.x;
    if (paper) {
      ended[i].solution = paper_bfgs(layout, data, x, options.max_iterations);
      quality[i] = ended[i].solution.objective;
    } else {
      ended[i] = robust_least_squares(layout, data, priors, x, no_factor, linear,
                                      options.robust_sigma, options.max_iterations);
      quality[i] = measured_scale(layout, data, ended[i].solution, options.robust_sigma);
    }
  });
  const auto best =
      static_cast<std::size_t>(std::min_element(quality.begin(), quality.end()) - quality.begin());
  out.start_iterations = tried[followed[best]].robust.solution.iterations;
  out.solution = std::move(ended[best].solution);
  out.scale = ended[best].scale;
  if (!paper) {
    out.solution = with_idle_terms_offered(
        {layout, data, priors, {.scale = out.scale, .huber_sigma = options.robust_sigma}}, linear,
        descent.terms(), std::move(out.solution), {.max_iterations = options.max_iterations});
  }
  out.phase_seconds.emplace_back("all points", clock.lap());
  return out;
}

}  // namespace umov::invert
