#include "host/trace/launch.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

namespace umov::trace {
namespace {

// A Hilbert curve meets each cell of every level once, and goes from each to one that touches it
// along an edge. Both together are its definition up to turns.
TEST(HilbertCurve, GoesThroughEachCellOnceAndFromNeighbourToNeighbour) {
  for (const int side : {2, 4, 8, 16, 32, 64, 512, 4096}) {
    const long cells = static_cast<long>(side) * side;
    std::vector<bool> seen(static_cast<std::size_t>(cells), false);
    long x = 0;
    long y = 0;
    for (long i = 0; i < cells; ++i) {
      const auto point =
          on_hilbert_curve((static_cast<double>(i) + 0.5) / static_cast<double>(cells), 0.5, 0.5);
      const auto nx = static_cast<long>(point[0] * side);
      const auto ny = static_cast<long>(point[1] * side);
      ASSERT_TRUE(nx >= 0 && nx < side && ny >= 0 && ny < side);
      const auto cell = static_cast<std::size_t>(nx * side + ny);
      ASSERT_FALSE(seen[cell]) << side << ", cell " << i;
      seen[cell] = true;
      if (i > 0) {
        ASSERT_EQ(std::labs(nx - x) + std::labs(ny - y), 1) << side << ", cell " << i;
      }
      x = nx;
      y = ny;
    }
  }
}

TEST(LaunchPoint, IsUniformAndHasItsShareOfTheBlock) {
  // χ² of 40² cells that have nothing to do with those of the curve, over blocks of an odd size.
  constexpr int side = 40;
  constexpr std::uint64_t launches = 1000;
  constexpr std::uint64_t blocks = 160;
  std::vector<double> counts(static_cast<std::size_t>(side * side), 0.0);
  double most_apart = 0.0;
  for (std::uint64_t block = 0; block < blocks; ++block) {
    std::array<int, 4> quarters{};
    std::array<double, 2> before{};
    for (std::uint64_t i = 0; i < launches; ++i) {
      const auto p = launch_point(i, launches, uniforms(3, block * launches + i, 0));
      ASSERT_TRUE(p[0] >= 0.0 && p[0] < 1.0 && p[1] >= 0.0 && p[1] < 1.0);
      ++counts[static_cast<std::size_t>(p[0] * side) * side +
               static_cast<std::size_t>(p[1] * side)];
      ++quarters[2 * static_cast<std::size_t>(2.0 * p[0]) + static_cast<std::size_t>(2.0 * p[1])];
      if (i > 0) most_apart = std::max(most_apart, std::hypot(p[0] - before[0], p[1] - before[1]));
      before = p;
    }
    for (const int count : quarters) EXPECT_EQ(count, 250);
  }
  double chi2 = 0.0;
  const double expected = static_cast<double>(launches * blocks) / (side * side);
  for (const double n : counts) chi2 += (n - expected) * (n - expected) / expected;
  const double freedom = side * side - 1.0;
  // Shares make counts more even than chance does, so χ² may well be too small.
  EXPECT_LT(chi2, freedom + 4.0 * std::sqrt(2.0 * freedom));
  // Two stretches of a thousandth each: at most the diagonals of two squares of that area and more.
  EXPECT_LT(most_apart, 6.0 / std::sqrt(static_cast<double>(launches)));
}

}  // namespace
}  // namespace umov::trace
