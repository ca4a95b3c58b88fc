// Where particles lie: what they cover, and that they do not overlap unless they may.
#include "host/surface/particles.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/errors/error.hpp"
#include "host/surface/ground.hpp"

namespace umov::surface {
namespace {

constexpr double size = 1000.0;
constexpr double pi = 3.14159265358979;

double area(const std::vector<Disc>& discs) {
  double sum = 0.0;
  for (const Disc& d : discs) sum += pi * d.radius * d.radius;
  return sum / (size * size);
}

double apart(const Disc& a, const Disc& b) {
  return std::hypot(std::remainder(a.x - b.x, size), std::remainder(a.y - b.y, size));
}

// The deepest overlap of two discs over the sum of their radii.
double deepest_overlap(const std::vector<Disc>& discs) {
  double worst = -1.0;
  for (std::size_t i = 0; i < discs.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const double sum = discs[i].radius + discs[j].radius;
      worst = std::max(worst, (sum - apart(discs[i], discs[j])) / sum);
    }
  }
  return worst;
}

double nearest_over_mean(const std::vector<Disc>& discs) {
  double sum = 0.0;
  for (const Disc& d : discs) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const Disc& e : discs) {
      if (&d != &e) nearest = std::min(nearest, apart(d, e));
    }
    sum += nearest;
  }
  const double n = static_cast<double>(discs.size());
  // 1 for points at random (Clark and Evans 1954).
  return sum / n / (0.5 * size / std::sqrt(n));
}

// Variance over mean of the numbers in 10 × 10 squares; 1 for points at random.
double unevenness(const std::vector<Disc>& discs) {
  std::vector<double> counts(100, 0.0);
  for (const Disc& d : discs) {
    ++counts[static_cast<std::size_t>(d.y / size * 10) * 10 +
             static_cast<std::size_t>(d.x / size * 10)];
  }
  const double mean = static_cast<double>(discs.size()) / 100.0;
  double sum = 0.0;
  for (const double c : counts) sum += (c - mean) * (c - mean);
  return sum / 100.0 / mean;
}

std::vector<Disc> laid(const Laying& laying, std::uint64_t seed = 3) {
  std::vector<Disc> discs;
  lay(discs, laying, size, seed);
  for (const Disc& d : discs) {
    EXPECT_GE(d.x, 0.0);
    EXPECT_LT(d.x, size);
    EXPECT_GE(d.y, 0.0);
    EXPECT_LT(d.y, size);
  }
  return discs;
}

TEST(Particles, CoverWhatIsAskedWithoutOverlap) {
  std::vector<Disc> discs = laid({{40.0, 1.3}, 0.2});
  const std::size_t first = discs.size();
  lay(discs, {{20.0}, 0.15}, size, 4);
  EXPECT_LE(deepest_overlap(discs), 1e-12);
  EXPECT_NEAR(area(discs), 0.35, 0.002);
  EXPECT_NEAR(covered_share(discs, size), 0.35, 0.003);
  EXPECT_GT(discs.size(), first + 400);
}

TEST(Particles, PushEachOtherApartWhereTheGroundIsCrowded) {
  std::vector<Disc> discs = laid({{40.0, 1.2}, 0.3});
  lay(discs, {{35.0}, 0.47}, size, 5);
  EXPECT_LE(deepest_overlap(discs), 2e-6);
  EXPECT_NEAR(area(discs), 0.77, 0.002);
  const std::vector<Disc> before = discs;
  EXPECT_THROW(lay(discs, {{25.0}, 0.2}, size, 6), Error);
  ASSERT_EQ(discs.size(), before.size()) << "nothing is left of a refusal";
  EXPECT_EQ(discs.front().x, before.front().x);
}

TEST(Particles, LieAsTheirLayoutSays) {
  const double random = nearest_over_mean(laid({{20.0}, 0.1}));
  const double spaced = nearest_over_mean(laid({{20.0}, 0.1, Layout::poisson_disk}));
  const double grid = nearest_over_mean(laid({{20.0}, 0.1, Layout::grid}));
  EXPECT_NEAR(random, 1.1, 0.1) << "1 but for the room that particles take";
  EXPECT_GT(spaced, 1.5);
  EXPECT_GT(unevenness(laid({{10.0}, 0.1, Layout::cluster})), 2.0);
  EXPECT_LT(unevenness(laid({{10.0}, 0.1})), 1.1);
  EXPECT_NEAR(grid, 2.0, 1e-6);
  EXPECT_EQ(laid({{20.0}, 0.1}, 7).front().x, laid({{20.0}, 0.1}, 7).front().x);
  EXPECT_NE(laid({{20.0}, 0.1}, 7).front().x, laid({{20.0}, 0.1}, 8).front().x);
  EXPECT_THROW(laid({{20.0}, 0.8, Layout::cluster}), Error);
  EXPECT_THROW(laid({{20.0}, 0.85, Layout::grid}), Error);
}

TEST(Particles, CoverUpTo95PercentWhereTheyMayOverlap) {
  for (const Layout layout :
       {Layout::random, Layout::poisson_disk, Layout::cluster, Layout::grid}) {
    const std::vector<Disc> discs =
        laid({.sizes = {40.0}, .coverage = 0.95, .layout = layout, .overlap = true});
    EXPECT_NEAR(covered_share(discs, size), 0.95, layout == Layout::grid ? 0.03 : 0.002);
    EXPECT_GT(deepest_overlap(discs), 0.1);
  }
  // Of discs at random, 1 - exp(-sum of their areas) is covered.
  const std::vector<Disc> discs = laid({.sizes = {20.0}, .coverage = 0.6, .overlap = true});
  EXPECT_NEAR(area(discs), -std::log(1.0 - 0.6), 0.05);
  EXPECT_THROW(laid({.sizes = {20.0}, .coverage = 0.96, .overlap = true}), Error);
  EXPECT_THROW(laid({{20.0}, 0.0}), Error);
  EXPECT_THROW(laid({{600.0}, 0.1}), Error);
}

TEST(Ground, HoldsSpheresOnItsSummits) {
  std::vector<double> heights(100, 0.0);
  heights[5 * 10 + 5] = 1.0;  // at (5, 5) of a square of 10
  const Ground ground(heights, 10, 10.0);
  EXPECT_NEAR(ground.rest(5.0, 5.0, 2.0), 3.0, 1e-12);
  EXPECT_NEAR(ground.rest(6.0, 5.0, 2.0), 1.0 + std::sqrt(3.0), 1e-12);
  EXPECT_NEAR(ground.rest(0.0, 0.0, 2.0), 2.0, 1e-12);
  EXPECT_NEAR(ground.rest(14.0, 5.0, 2.0), 1.0 + std::sqrt(3.0), 1e-12) << "over the edge";
  EXPECT_EQ(Ground(0.5).rest(1.0, 1.0, 2.0), 2.5);
}

}  // namespace
}  // namespace umov::surface
