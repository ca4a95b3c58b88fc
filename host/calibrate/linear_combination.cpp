#include "host/calibrate/linear_combination.hpp"

#include <map>

namespace umov::calibrate {

double LinearCombination::noise_variance(const formats::BrdfTable& table) const {
  std::map<std::size_t, double> merged;
  for (const auto& [point, c] : terms) merged[point] += c;
  double sum = 0;
  for (const auto& [point, c] : merged) {
    const double u = c * table.points.brdf_u[point];
    sum += u * u;
  }
  return sum;
}

double LinearCombination::shared_variance(const formats::BrdfTable& table) const {
  double sum = 0;
  for (const auto& factor : table.factors) {
    double shift = 0;
    for (const auto& [point, c] : terms) shift += c * factor.per_point[point];
    sum += shift * shift;
  }
  return sum;
}

LinearCombination weighted_mean_of(const formats::BrdfTable& table,
                                   const std::vector<std::size_t>& points) {
  LinearCombination mean;
  double weights = 0;
  for (std::size_t i : points) {
    const double u = table.points.brdf_u[i];
    weights += u > 0 ? 1.0 / (u * u) : 0.0;
  }
  for (std::size_t i : points) {
    const double u = table.points.brdf_u[i];
    const double share = weights > 0 ? (u > 0 ? 1.0 / (u * u * weights) : 0.0)
                                     : 1.0 / static_cast<double>(points.size());
    mean.add(i, share);
  }
  return mean;
}

}  // namespace umov::calibrate
