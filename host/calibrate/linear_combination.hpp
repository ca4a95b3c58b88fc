// A quantity that is linear in points of a BRDF table, with its uncertainty.
#pragma once

#include <utility>
#include <vector>

#include "host/formats/brdf_table.hpp"

namespace umov::calibrate {

/// Σ coefficient · brdf[point].
struct LinearCombination {
  std::vector<std::pair<std::size_t, double>> terms;

  void add(std::size_t point, double coefficient) { terms.emplace_back(point, coefficient); }
  void add(const LinearCombination& other, double coefficient) {
    for (const auto& [point, c] : other.terms) terms.emplace_back(point, coefficient * c);
  }
  bool empty() const { return terms.empty(); }
  double value(const formats::BrdfTable& table) const {
    double sum = 0;
    for (const auto& [point, c] : terms) sum += c * table.points.brdf_per_sr[point];
    return sum;
  }
  /// Variance from the points' own noise; a point may occur more than once.
  double noise_variance(const formats::BrdfTable& table) const;
  /// Variance from the factors that points share.
  double shared_variance(const formats::BrdfTable& table) const;
};

/// Mean of points with weights 1/u².
LinearCombination weighted_mean_of(const formats::BrdfTable& table,
                                   const std::vector<std::size_t>& points);

}  // namespace umov::calibrate
