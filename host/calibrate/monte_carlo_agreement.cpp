#include <algorithm>
#include <cmath>

#include <boost/math/special_functions/erf.hpp>

#include "host/calibrate/monte_carlo.hpp"

namespace umov::calibrate {

MonteCarloAgreement compare_with_draws(const MonteCarlo& draws, const std::vector<double>& u_per_sr,
                                       const std::vector<int>& used) {
  constexpr double two_digits = 0.05;
  MonteCarloAgreement result;
  double sum = 0;
  std::vector<double> logs;
  for (std::size_t i = 0; i < u_per_sr.size(); ++i) {
    if (used[i] == 0 || !(u_per_sr[i] > 0) || !(draws.u_per_sr[i] > 0)) continue;
    logs.push_back(std::log(draws.u_per_sr[i] / u_per_sr[i]));
    sum += logs.back();
  }
  result.points = logs.size();
  if (logs.empty()) return result;
  const auto count = static_cast<double>(logs.size());
  const double scatter = 1.0 / std::sqrt(2.0 * (static_cast<double>(draws.draws) - 1.0));
  // One point of all may be out in one case of a thousand.
  const double z = std::sqrt(2.0) * boost::math::erfc_inv(1e-3 / count);
  result.mean_ratio = std::exp(sum / count);
  // Shared causes let all points scatter together, in the worst case as one.
  result.allowed_mean = two_digits + 3.0 * scatter;
  result.allowed_single = two_digits + z * scatter;
  const auto [low, high] = std::minmax_element(logs.begin(), logs.end());
  result.smallest_ratio = std::exp(*low);
  result.largest_ratio = std::exp(*high);
  for (double l : logs) result.outside += std::abs(l) > result.allowed_single;
  result.agrees =
      result.outside == 0 && std::abs(std::log(result.mean_ratio)) <= result.allowed_mean;
  return result;
}

}  // namespace umov::calibrate
