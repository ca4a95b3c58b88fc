// A Gaussian rough surface: its statistics, and its single bounce against the microfacet model.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "host/brdf/evaluate.hpp"
#include "host/errors/error.hpp"
#include "host/surface/gaussian_heights.hpp"
#include "host/trace/hemisphere.hpp"
#include "tests/unit/trace/over_cell.hpp"
#include "tests/unit/trace/scenes.hpp"

namespace umov::surface {
namespace {

using optics::element;
using optics::Mueller;
using optics::radians;
using trace::Cell;
using trace::Hemisphere;

TEST(GaussianHeights, HaveTheCorrelationAndSlopeAskedFor) {
  constexpr std::size_t side = 512;
  const std::vector<double> z = gaussian_heights(side, 1.0, 8.0 / side, 0.2, 5);
  double square = 0.0, shifted = 0.0, slope = 0.0;
  for (std::size_t y = 0; y < side; ++y) {
    for (std::size_t x = 0; x < side; ++x) {
      const double a = z[y * side + x];
      square += a * a;
      shifted += a * z[y * side + (x + 8) % side];
      const double step = (z[y * side + (x + 1) % side] - a) * side;
      slope += step * step;
    }
  }
  const double n = side * side;
  EXPECT_NEAR(std::sqrt(slope / n), 0.2, 0.005) << "x alone; the mean of x and y is exact";
  EXPECT_NEAR(shifted / square, std::exp(-1.0), 0.03) << "at one correlation length";
  // σ = slope · correlation/√2; facets of 1/8 of a correlation length see .4 % less slope.
  EXPECT_NEAR(std::sqrt(square / n), 0.2 * 8.0 / side / std::sqrt(2.0), 0.02 * 0.0022);
  EXPECT_EQ(z, gaussian_heights(side, 1.0, 8.0 / side, 0.2, 5));
  EXPECT_THROW(gaussian_heights(side, 1.0, 2.0 / side, 0.2, 5), Error);
  EXPECT_THROW(gaussian_heights(side, 1.0, 0.2, 0.2, 5), Error);
  EXPECT_THROW(gaussian_heights(side, 1.0, 0.1, 4.0, 5), Error);
}

TEST(GaussianSurface, InSingleBounceIsTheMicrofacetModel) {
  // Single bounces of several pieces of surface; their scatter is that of the slopes as well.
  constexpr double slope = 0.2;
  constexpr std::size_t side = 320;
  constexpr int pieces = 10;
  constexpr std::uint64_t launches = 40'000;
  const brdf::Model model = brdf::Model::by_name("microfacet:shadowing=smith-correlated");
  const std::vector<double> values{1.5, 2.0, slope, 1.0};
  ASSERT_EQ(model.parameters().size(), values.size());
  const Hemisphere hemisphere(5, 0, 0.0);
  for (const double degrees : {0.0, 60.0}) {
    const double theta_i = radians(degrees);
    std::vector<std::array<trace::test::Mean, 16>> means(hemisphere.cells());
    trace::test::Mean all;
    for (int piece = 0; piece < pieces; ++piece) {
      trace::Scene scene({0.6});
      const auto seed = static_cast<std::uint64_t>(100 + piece);
      scene.add_height_field(side, side, gaussian_heights(side, 1.0, 5.0 / side, slope, seed),
                             scene.add(trace::Conductor{{1.5}, {2.0}}));
      std::vector<Mueller<double>> sums(hemisphere.cells(), Mueller<double>(0.0));
      trace::test::shine(scene, theta_i, launches, seed + 1000, [&](const trace::Exit& exit) {
        if (exit.meetings == 1 && exit.direction.z > 0.0) {
          sums[hemisphere.find(exit.direction)] += exit.weight;
        }
      });
      double seen = 0.0;
      for (std::size_t i = 0; i < sums.size(); ++i) {
        const Cell cell = hemisphere.cell(i);
        sums[i] /= static_cast<double>(launches) * cell.projected;
        if (cell.theta_high < radians(61.0)) seen += sums[i][0][0] * cell.projected;
        for (int e = 0; e < 16; ++e) {
          means[i][static_cast<std::size_t>(e)].add(element(sums[i], e / 4, e % 4));
        }
      }
      all.add(seen);
    }
    double expected_all = 0.0;
    double chi2 = 0.0;
    int count = 0;
    for (std::size_t i = 0; i < hemisphere.cells(); ++i) {
      const Cell cell = hemisphere.cell(i);
      if (cell.theta_high > radians(61.0)) continue;
      const Mueller<double> expected = trace::over_cell(model, values, 0.6, theta_i, cell, 24);
      expected_all += expected[0][0] * cell.projected;
      if (expected[0][0] < 0.05) continue;
      for (int e = 0; e < 16; ++e) {
        const trace::test::Mean& found = means[i][static_cast<std::size_t>(e)];
        if (found.error() < 1e-3 * expected[0][0]) continue;
        const double difference = found.value() - element(expected, e / 4, e % 4);
        chi2 += difference * difference / (found.error() * found.error());
        ++count;
        EXPECT_LT(std::abs(difference), 0.01 * expected[0][0] + 5.0 * found.error())
            << degrees << "°, cell " << i << " element " << e / 4 << e % 4;
      }
    }
    EXPECT_NEAR(all.value() / expected_all, 1.0, 0.01) << degrees;
    EXPECT_LT(all.error(), 0.006 * expected_all) << degrees;
    // Scatter of 10 pieces, t-distributed: the mean of t² is 9/7.
    EXPECT_LT(chi2 / count, 1.8) << degrees << "°, " << count << " elements";
    EXPECT_GT(count, 30);
  }
}

}  // namespace
}  // namespace umov::surface
