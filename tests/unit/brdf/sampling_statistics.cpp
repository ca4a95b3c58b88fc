#include "tests/unit/brdf/sampling_statistics.hpp"

#include <algorithm>
#include <boost/math/special_functions/gamma.hpp>
#include <cmath>

#include "host/optics/angles.hpp"

namespace umov::brdf::statistics {
namespace {

using optics::pi;
using optics::Vec3;

/// Bins of a polar angle about an axis (the normal, or the mirror direction) and an azimuth.
struct Grid {
  Vec3<double> axis, beside;  ///< beside: azimuth 0
  std::vector<double> polar;  ///< borders, from 0
  std::size_t sectors;

  std::size_t size() const { return (polar.size() - 1) * sectors; }

  Vec3<double> direction(double angle, double azimuth) const {
    const Vec3<double> y(0.0, 1.0, 0.0);
    return axis * std::cos(angle) +
           (beside * std::cos(azimuth) + y * std::sin(azimuth)) * std::sin(angle);
  }

  std::size_t bin_of(const Vec3<double>& d) const {
    const double x = optics::dot(d, beside);
    const double angle = std::atan2(std::hypot(x, d.y), optics::dot(d, axis));
    const double turn = std::atan2(d.y, x) / (2.0 * pi) + 0.5;
    const auto ring = static_cast<std::size_t>(
        std::upper_bound(polar.begin() + 1, polar.end() - 1, angle) - polar.begin() - 1);
    const auto count = static_cast<double>(sectors);
    return ring * sectors +
           std::min(static_cast<std::size_t>(std::max(0.0, turn * count)), sectors - 1);
  }

  /// ∫ density dω over a bin by the midpoint rule, in the angle's square: even over a narrow cap.
  /// Refined while that changes it; fine from the beginning where the horizon cuts the bin, since
  /// grazing light may fill a thin strip along it.
  double integral(std::size_t bin, double theta_i, const Density& density) const {
    int steps = cut_by_horizon(bin) ? 48 : 8;
    double sum = midpoints(bin, theta_i, density, steps);
    for (steps *= 2; steps <= 128; steps *= 2) {
      const double before = sum;
      sum = midpoints(bin, theta_i, density, steps);
      if (std::abs(sum - before) < 0.01 * sum + 2e-5) break;
    }
    return sum;
  }

  bool cut_by_horizon(std::size_t bin) const {
    int below = 0;
    for (int k = 0; k < 9; ++k) {
      const double angle =
          polar[bin / sectors] + (polar[bin / sectors + 1] - polar[bin / sectors]) * 0.5 * (k / 3);
      const double turn =
          (static_cast<double>(bin % sectors) + 0.5 * (k % 3)) / static_cast<double>(sectors);
      below += direction(angle, (2.0 * turn - 1.0) * pi).z < 0.0 ? 1 : 0;
    }
    return below > 0 && below < 9;
  }

  double midpoints(std::size_t bin, double theta_i, const Density& density, int steps) const {
    const double from = polar[bin / sectors], to = polar[bin / sectors + 1];
    const double first =
        -pi + 2.0 * pi * static_cast<double>(bin % sectors) / static_cast<double>(sectors);
    const double width = 2.0 * pi / static_cast<double>(sectors);
    double sum = 0.0;
    for (int i = 0; i < steps; ++i) {
      const double square = from * from + (to * to - from * from) * (i + 0.5) / steps;
      const double angle = std::sqrt(square);
      for (int j = 0; j < steps; ++j) {
        const Vec3<double> d = direction(angle, first + width * (j + 0.5) / steps);
        if (!(d.z > 0.0)) continue;
        const Geometry<double> g{theta_i, std::atan2(std::hypot(d.x, d.y), d.z),
                                 std::atan2(d.y, d.x)};
        // sin α dα = (sin α/2α) d(α²).
        sum += density(g) * 0.5 * std::sin(angle) / angle;
      }
    }
    return sum * width * (to * to - from * from) / (steps * steps);
  }
};

Grid make_grid(const Sampler& sampler, double theta_i, Bins bins, std::uint64_t seed) {
  if (bins == Bins::polar) {
    Grid grid{{0.0, 0.0, 1.0}, {1.0, 0.0, 0.0}, {}, 16};
    for (int i = 0; i <= 18; ++i) grid.polar.push_back(0.5 * pi * i / 18);
    return grid;
  }
  Grid grid{{std::sin(theta_i), 0.0, std::cos(theta_i)},
            {std::cos(theta_i), 0.0, -std::sin(theta_i)},
            {0.0},
            12};
  std::vector<double> angles;
  for (std::uint64_t i = 0; i < 2000; ++i) {
    const auto u = uniform(seed + 1000003, i);
    const auto sample = sampler.sample(theta_i, u[0], u[1], u[2]);
    if (!sample || sample->mirror) continue;
    angles.push_back(2.0 *
                     std::asin(std::min(1.0, 0.5 * glm::length(sample->direction - grid.axis))));
  }
  std::sort(angles.begin(), angles.end());
  constexpr std::size_t rings = 16;
  for (std::size_t i = 1; i < rings; ++i) {
    const double border =
        angles.empty() ? 0.1 * static_cast<double>(i) : angles[angles.size() * i / rings];
    if (border > 1.02 * grid.polar.back()) grid.polar.push_back(border);
  }
  // Beyond the outermost of them the density may fall over many decades.
  const double end = 0.5 * pi + theta_i;
  while (grid.polar.back() * 1.4 < end) grid.polar.push_back(grid.polar.back() * 1.3);
  grid.polar.push_back(std::max(end, 1.001 * grid.polar.back()));
  return grid;
}

}  // namespace

Fit chi_square(const Sampler& sampler, const Density& density, double mirror_probability,
               double theta_i, Bins bins, int count, std::uint64_t seed) {
  const Grid grid = make_grid(sampler, theta_i, bins, seed);
  const std::size_t mirror_bin = grid.size(), nothing_bin = grid.size() + 1;
  std::vector<double> seen(grid.size() + 2, 0.0), expected(grid.size() + 2, 0.0);
  for (int i = 0; i < count; ++i) {
    const auto u = uniform(seed, static_cast<std::uint64_t>(i));
    const auto sample = sampler.sample(theta_i, u[0], u[1], u[2]);
    seen[!sample          ? nothing_bin
         : sample->mirror ? mirror_bin
                          : grid.bin_of(sample->direction)] += 1.0;
  }
  Fit fit;
  for (std::size_t k = 0; k < grid.size(); ++k) {
    expected[k] = grid.integral(k, theta_i, density);
    fit.integral += expected[k];
  }
  expected[mirror_bin] = mirror_probability;
  expected[nothing_bin] = std::max(0.0, 1.0 - mirror_probability - fit.integral);
  fit.nothing = seen[nothing_bin] / count;

  double rest_seen = 0.0, rest_expected = 0.0;
  const auto add = [&](double observed, double wanted) {
    fit.chi2 += (observed - wanted) * (observed - wanted) / wanted;
    ++fit.bins;
  };
  for (std::size_t k = 0; k < seen.size(); ++k) {
    const double wanted = count * expected[k];
    if (wanted >= 10.0) {
      add(seen[k], wanted);
    } else {
      rest_seen += seen[k];
      rest_expected += wanted;
    }
  }
  // An expectation of a few is tested as if it were 3: whoever draws where the density is 0 is
  // caught, the integration's own rounding isn't.
  if (rest_seen > 0.0 || rest_expected >= 3.0) add(rest_seen, std::max(rest_expected, 3.0));
  fit.p = fit.bins > 1 ? boost::math::gamma_q(0.5 * (fit.bins - 1), 0.5 * fit.chi2) : 1.0;
  return fit;
}

}  // namespace umov::brdf::statistics
