// The share of a Gaussian beam that a disc holds, and what it grows by.
#include "host/gap/scan/effects/footprint.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace umov::gap::scan {
namespace {

/// By a fine grid over the disc: 1/e² radius `ratio` of the disc's, stretched by 1/`cosine` along
/// x.
double by_grid(double ratio, double cosine) {
  constexpr int steps = 1200;
  const double h = 2.0 / steps;
  double sum = 0;
  for (int i = 0; i < steps; ++i) {
    for (int j = 0; j < steps; ++j) {
      const double x = -1.0 + h * (i + 0.5), y = -1.0 + h * (j + 0.5);
      if (x * x + y * y > 1.0) continue;
      sum += std::exp(-2.0 * (x * x * cosine * cosine + y * y) / (ratio * ratio));
    }
  }
  return sum * h * h * 2.0 * cosine / (optics::pi * ratio * ratio);
}

TEST(DiscShare, OfARoundBeamIsItsClosedForm) {
  for (const double ratio : {0.5, 0.8, 1.0, 1.6})
    EXPECT_NEAR(share_on_disc(ratio, 1.0), 1.0 - std::exp(-2.0 / (ratio * ratio)), 2e-6) << ratio;
}

TEST(DiscShare, OfAStretchedBeamIsItsIntegral) {
  for (const auto& [ratio, cosine] : {std::pair{0.7, 0.5}, {1.2, 0.8}, {0.9, 0.26}})
    EXPECT_NEAR(share_on_disc(ratio, cosine), by_grid(ratio, cosine), 1e-4) << ratio;
}

TEST(DiscShare, HasItsOwnDerivatives) {
  for (const auto& [ratio, cosine] : {std::pair{0.7, 0.5}, {1.2, 0.8}, {0.6, 1.0}, {1.5, 1.7}}) {
    const DiscShare at = compute_disc_share(ratio, cosine);
    const double h = 1e-5;
    EXPECT_NEAR(at.by_ratio,
                (compute_disc_share(ratio + h, cosine).value -
                 compute_disc_share(ratio - h, cosine).value) /
                    (2 * h),
                1e-8);
    EXPECT_NEAR(at.by_cosine,
                (compute_disc_share(ratio, cosine + h).value -
                 compute_disc_share(ratio, cosine - h).value) /
                    (2 * h),
                1e-8);
  }
}

TEST(DiscShare, RemembersNoOther) {
  // More pairs than there are places in memory, asked for twice.
  for (int round = 0; round < 2; ++round)
    for (int i = 0; i < 60; ++i)
      for (int j = 0; j < 60; ++j) {
        const double ratio = 0.5 + 0.01 * i, cosine = 0.2 + 0.01 * j;
        ASSERT_EQ(disc_share(ratio, cosine).value, compute_disc_share(ratio, cosine).value);
      }
}

}  // namespace
}  // namespace umov::gap::scan
