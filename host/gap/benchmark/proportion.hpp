// Figures of a score with their uncertainty: proportions by Clopper and Pearson, others by the
// bootstrap over cases; the calibration error of probabilities.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "host/gap/engine/diagnosis.hpp"

namespace umov::gap::benchmark {

/// hits/n with its exact two-sided 95 % interval (C. Clopper and E. Pearson 1934, Biometrika 26).
/// n = 0: not a number between 0 and 1.
Interval clopper_pearson(std::size_t hits, std::size_t n);

/// A statistic of n cases and its 95 % percentile interval over `draws` samples of n cases with
/// replacement. The statistic is given the numbers of the cases and may say NaN (left out).
Interval bootstrap(std::size_t n, const std::function<double(std::span<const std::size_t>)>& value,
                   int draws, std::uint64_t seed);

/// The value below which a share q of the values lies, interpolated; NaN for none.
double quantile(std::vector<double> values, double q);

/// A stated probability and what came of it.
struct Forecast {
  double probability = 0;
  bool came = false;
};

/// Expected calibration error: forecasts in order of probability cut into `bins` of equal number
/// (ties stay together), mean over bins of |mean probability − share that came|, weighted by their
/// numbers.
double calibration_error(std::vector<Forecast> forecasts, int bins = 10);
/// Its mean where the probabilities are right and only `n` outcomes are drawn: Σ over bins of
/// E|outcomes − probabilities|, by `draws` drawings.
double calibration_floor(const std::vector<Forecast>& forecasts, int bins, int draws,
                         std::uint64_t seed);

}  // namespace umov::gap::benchmark
