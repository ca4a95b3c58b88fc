#include "host/trace/random_stream.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace umov::trace {
namespace {

// Each of the eight is uniform, and no two of them, nor those of neighbouring events or paths, nor
// the four of uniforms(), have anything to do with each other.
TEST(EightUniforms, AreUniformAndIndependent) {
  constexpr std::uint64_t paths = 40'000;
  std::array<double, 8> sum{}, squares{};
  double most = 0.0;
  std::array<std::array<double, 28>, 8> products{};
  for (std::uint64_t path = 0; path < paths; ++path) {
    const auto u = eight_uniforms(3, path, 5);
    const auto event = eight_uniforms(3, path, 6);
    const auto next = eight_uniforms(3, path + 1, 5);
    const auto seed = eight_uniforms(4, path, 5);
    const auto four = uniforms(3, path, 5);
    for (std::size_t i = 0; i < 8; ++i) {
      ASSERT_TRUE(u[i] > 0.0 && u[i] < 1.0);
      sum[i] += u[i];
      squares[i] += u[i] * u[i];
      const auto with = [&](std::size_t k, double other) {
        products[i][k] += 12.0 * (u[i] - 0.5) * (other - 0.5);
      };
      for (std::size_t k = 0; k < 8; ++k) {
        if (k != i) with(k, u[k]);
        with(8 + k, event[k]);
        with(16 + k, k < 4 ? four[k] : next[k]);
      }
      for (std::size_t k = 0; k < 4; ++k) with(24 + k, seed[2 * k]);
    }
  }
  const double n = paths;
  for (std::size_t i = 0; i < 8; ++i) {
    EXPECT_NEAR(sum[i] / n, 0.5, 5.0 / std::sqrt(12.0 * n));
    EXPECT_NEAR(squares[i] / n, 1.0 / 3.0, 5.0 * std::sqrt(4.0 / 45.0 / n));
    for (const double product : products[i])
      most = std::max(most, std::abs(product) / std::sqrt(n));
  }
  EXPECT_LT(most, 4.6);  // of 216 correlations in units of their standard errors
}

}  // namespace
}  // namespace umov::trace
