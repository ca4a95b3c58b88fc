#include "host/gap/benchmark/proportion.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include <boost/math/distributions/beta.hpp>

namespace umov::gap::benchmark {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double tail = 0.025;

double uniform(std::mt19937_64& random) {
  return static_cast<double>(random() >> 11) * 0x1p-53;
}

/// First places of bins over forecasts in ascending order; ends with their number.
std::vector<std::size_t> bin_edges(const std::vector<Forecast>& sorted, int bins) {
  const std::size_t n = sorted.size();
  std::vector<std::size_t> edges{0};
  for (int b = 1; b <= bins; ++b) {
    std::size_t edge = n * static_cast<std::size_t>(b) / static_cast<std::size_t>(bins);
    while (edge > 0 && edge < n && sorted[edge].probability == sorted[edge - 1].probability) ++edge;
    if (edge > edges.back()) edges.push_back(edge);
  }
  return edges;
}

std::vector<Forecast> ascending(std::vector<Forecast> forecasts) {
  std::stable_sort(forecasts.begin(), forecasts.end(), [](const Forecast& a, const Forecast& b) {
    return a.probability < b.probability;
  });
  return forecasts;
}

double error_of(const std::vector<Forecast>& sorted, const std::vector<std::size_t>& edges) {
  double error = 0;
  for (std::size_t b = 0; b + 1 < edges.size(); ++b) {
    double excess = 0;
    for (std::size_t i = edges[b]; i < edges[b + 1]; ++i)
      excess += (sorted[i].came ? 1.0 : 0.0) - sorted[i].probability;
    error += std::abs(excess);
  }
  return error / static_cast<double>(sorted.size());
}

}  // namespace

Interval clopper_pearson(std::size_t hits, std::size_t n) {
  if (n == 0) return {nan, 0, 1};
  const auto k = static_cast<double>(hits), m = static_cast<double>(n);
  using Beta = boost::math::beta_distribution<double>;
  Interval interval{k / m, 0, 1};
  if (hits > 0) interval.lo = boost::math::quantile(Beta(k, m - k + 1), tail);
  if (hits < n) interval.hi = boost::math::quantile(Beta(k + 1, m - k), 1 - tail);
  return interval;
}

double quantile(std::vector<double> values, double q) {
  if (values.empty()) return nan;
  std::sort(values.begin(), values.end());
  const double place = q * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, values.size() - 1);
  const double part = place - static_cast<double>(below);
  return (1 - part) * values[below] + part * values[above];
}

Interval bootstrap(std::size_t n, const std::function<double(std::span<const std::size_t>)>& value,
                   int draws, std::uint64_t seed) {
  std::vector<std::size_t> picks(n);
  for (std::size_t i = 0; i < n; ++i) picks[i] = i;
  Interval interval{value(picks), nan, nan};
  if (n == 0) return interval;
  std::mt19937_64 random(seed);
  std::vector<double> drawn;
  for (int d = 0; d < draws; ++d) {
    for (std::size_t& pick : picks) pick = random() % n;
    const double one = value(picks);
    if (!std::isnan(one)) drawn.push_back(one);
  }
  interval.lo = quantile(drawn, tail);
  interval.hi = quantile(drawn, 1 - tail);
  return interval;
}

double calibration_error(std::vector<Forecast> forecasts, int bins) {
  if (forecasts.empty()) return nan;
  const std::vector<Forecast> sorted = ascending(std::move(forecasts));
  return error_of(sorted, bin_edges(sorted, bins));
}

double calibration_floor(const std::vector<Forecast>& forecasts, int bins, int draws,
                         std::uint64_t seed) {
  if (forecasts.empty()) return nan;
  std::vector<Forecast> sorted = ascending(forecasts);
  const std::vector<std::size_t> edges = bin_edges(sorted, bins);
  std::mt19937_64 random(seed);
  double sum = 0;
  for (int d = 0; d < draws; ++d) {
    for (Forecast& f : sorted) f.came = uniform(random) < f.probability;
    sum += error_of(sorted, edges);
  }
  return sum / draws;
}

}  // namespace umov::gap::benchmark
