#include "host/gap/engine/shares.hpp"

#include <cmath>
#include <numeric>

#include <gtest/gtest.h>

namespace umov::gap {
namespace {

/// Three goods of which the first two are worth something together only.
double value_of(Subset s) {
  return ((s & 3U) == 3U ? 12.0 : 0.0) + ((s & 4U) != 0U ? 5.0 : 0.0);
}

TEST(ShapleyValues, ShareWhatIsClosedTogether) {
  const std::vector<double> share = shapley_values(3, value_of, 1);
  EXPECT_NEAR(share[0], 6, 1e-12);
  EXPECT_NEAR(share[1], 6, 1e-12);
  EXPECT_NEAR(share[2], 5, 1e-12);
}

TEST(ShapleyValues, ManyPartsKeepTheSumAndSymmetry) {
  constexpr std::size_t parts = 9;
  // Worth the square of how many there are, and 7 more for the third.
  const auto crowd = [](Subset s) {
    const double count = __builtin_popcountll(s);
    return count * count + ((s & 4U) != 0U ? 7.0 : 0.0);
  };
  const std::vector<double> share = shapley_values(parts, crowd, 2);
  EXPECT_NEAR(std::accumulate(share.begin(), share.end(), 0.0), 81 + 7, 1e-9);
  for (std::size_t k = 0; k < parts; ++k) EXPECT_NEAR(share[k], k == 2 ? 16 : 9, 1e-9) << k;
}

TEST(ShapleyValues, FewSubsetsAreAskedFor) {
  std::size_t asked = 0;
  shapley_values(
      10,
      [&](Subset s) {
        ++asked;
        return static_cast<double>(s);
      },
      1);
  EXPECT_LE(asked, 10 * 9 + 2);
}

TEST(ShapleyValues, OfNothing) {
  EXPECT_TRUE(shapley_values(0, value_of, 1).empty());
}

}  // namespace
}  // namespace umov::gap
