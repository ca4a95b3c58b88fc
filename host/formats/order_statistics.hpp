// Median and quantiles of a handful of numbers.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

namespace umov::formats {

/// The value of rank p (n - 1), rounded, in ascending order; 0 where there are no values. p in
/// 0 … 1.
inline double quantile(std::vector<double> values, double p) {
  if (values.empty()) return 0;
  const auto rank =
      static_cast<std::ptrdiff_t>(std::floor(p * static_cast<double>(values.size() - 1) + 0.5));
  std::nth_element(values.begin(), values.begin() + rank, values.end());
  return values[static_cast<std::size_t>(rank)];
}

/// The middle value, the upper one of two; 0 where there are no values.
inline double median(std::vector<double> values) {
  return quantile(std::move(values), 0.5);
}

/// Between the two neighbouring ranks in proportion; 0 where there are no values.
inline double interpolated_quantile(std::vector<double> values, double p) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  const double at = p * static_cast<double>(values.size() - 1);
  const auto low = static_cast<std::size_t>(at);
  const std::size_t high = std::min(low + 1, values.size() - 1);
  return values[low] + (at - static_cast<double>(low)) * (values[high] - values[low]);
}

}  // namespace umov::formats
