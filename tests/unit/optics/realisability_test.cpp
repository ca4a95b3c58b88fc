#include "host/optics/realisability.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <random>

#include "host/optics/fresnel.hpp"

namespace umov::optics {
namespace {

std::array<double, 16> rows_of(const Mueller<double>& m) {
  std::array<double, 16> rows{};
  for (int i = 0; i < 16; ++i) rows[static_cast<std::size_t>(i)] = element(m, i / 4, i % 4);
  return rows;
}

std::array<double, 9> linear_part(const std::array<double, 16>& m) {
  std::array<double, 9> part{};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) part[3 * i + j] = m[4 * i + j];
  return part;
}

/// Mueller matrix ½ tr(σ_i J σ_j J†) of a random Jones matrix.
std::array<double, 16> random_pure(std::mt19937_64& random) {
  using Complex = std::complex<double>;
  std::normal_distribution<double> normal;
  std::array<Complex, 4> j;
  for (auto& e : j) e = {normal(random), normal(random)};
  const auto sigma = [](int k) -> std::array<Complex, 4> {
    const Complex i(0, 1);
    if (k == 0) return {1, 0, 0, 1};
    if (k == 1) return {1, 0, 0, -1};
    if (k == 2) return {0, 1, 1, 0};
    return {0, -i, i, 0};
  };
  const auto times = [](const std::array<Complex, 4>& a, const std::array<Complex, 4>& b) {
    return std::array<Complex, 4>{a[0] * b[0] + a[1] * b[2], a[0] * b[1] + a[1] * b[3],
                                  a[2] * b[0] + a[3] * b[2], a[2] * b[1] + a[3] * b[3]};
  };
  const std::array<Complex, 4> adjoint = {std::conj(j[0]), std::conj(j[2]), std::conj(j[1]),
                                          std::conj(j[3])};
  std::array<double, 16> m{};
  for (int a = 0; a < 4; ++a)
    for (int b = 0; b < 4; ++b) {
      const auto product = times(times(sigma(a), j), times(sigma(b), adjoint));
      m[static_cast<std::size_t>(4 * a + b)] = 0.5 * (product[0] + product[3]).real();
    }
  return m;
}

TEST(Realisability, OfADepolariserIsAQuarterAndOfAPureMatrixZero) {
  EXPECT_NEAR(realisability(rows_of(depolarizer<double>())).least_eigenvalue, 0.25, 1e-14);
  const auto glass = rows_of(reflection_mueller(1.5, 0.1, std::cos(1.0)));
  EXPECT_NEAR(realisability(glass).least_eigenvalue, 0, 1e-14);
  EXPECT_NEAR(linear_realisability(linear_part(glass)).least_eigenvalue, 0, 1e-13);
}

TEST(Realisability, HoldsForEveryMixtureOfJonesMatricesAndItsLinearPart) {
  std::mt19937_64 random(5);
  for (int trial = 0; trial < 200; ++trial) {
    std::array<double, 16> mixture{};
    const int parts = 1 + trial % 4;
    for (int part = 0; part < parts; ++part) {
      const auto pure = random_pure(random);
      for (std::size_t k = 0; k < 16; ++k) mixture[k] += pure[k] / parts;
    }
    const double full = realisability(mixture).least_eigenvalue;
    EXPECT_GT(full, -1e-12 * mixture[0]);
    // The best completion is at least as good as the one it came from.
    EXPECT_GT(linear_realisability(linear_part(mixture)).least_eigenvalue,
              full - 1e-9 * mixture[0]);
  }
}

TEST(Realisability, RefusesMoreAnalysedLightThanThereIs) {
  auto too_much = rows_of(depolarizer<double>());
  too_much[4] = 1.1;  // Q of unpolarised light beyond I
  EXPECT_LT(realisability(too_much).least_eigenvalue, -0.02);
  EXPECT_LT(linear_realisability(linear_part(too_much)).least_eigenvalue, -0.02);
}

TEST(Realisability, OfALinearPartWhoseEveryRowIsPossibleCanStillFail) {
  // Unpolarised light leaves polarised although Q and U pass nearly whole.
  const std::array<double, 9> part = {1, 0, 0, 0.5, 0.9, 0, 0, 0, 0.9};
  EXPECT_LT(linear_realisability(part).least_eigenvalue, -0.02);
}

TEST(Realisability, OfALinearPartIsTheBestOverManyCompletions) {
  // A search over all seven missing elements finds nothing better than the best m33 alone.
  std::mt19937_64 random(8);
  std::normal_distribution<double> normal;
  const std::array<double, 9> part = {1, 0.2, 0.1, -0.3, 0.5, 0.3, 0.1, -0.4, 0.2};
  const double claimed = linear_realisability(part).least_eigenvalue;
  std::array<double, 16> best{};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) best[4 * i + j] = part[3 * i + j];
  double found = realisability(best).least_eigenvalue;
  double size = 0.3;
  for (int trial = 0; trial < 6000; ++trial) {
    auto next = best;
    for (std::size_t k : {3, 7, 11, 12, 13, 14, 15}) next[k] += size * normal(random);
    const double value = realisability(next).least_eigenvalue;
    if (value > found) {
      found = value;
      best = next;
    }
    size = std::max(size * 0.9985, 1e-4);
  }
  EXPECT_LE(found, claimed + 1e-9);
  EXPECT_GT(found, claimed - 0.01);
}

TEST(Realisability, SlopesAreThoseOfTheLeastEigenvalue) {
  const std::array<double, 9> part = {1, 0.25, 0.1, 0.3, 0.6, 0.05, 0.02, -0.1, -0.45};
  const auto at = linear_realisability(part);
  for (std::size_t k = 0; k < 9; ++k) {
    auto up = part, down = part;
    up[k] += 1e-5;
    down[k] -= 1e-5;
    const double slope =
        (linear_realisability(up).least_eigenvalue - linear_realisability(down).least_eigenvalue) /
        2e-5;
    EXPECT_NEAR(at.slope[k], slope, 2e-4) << k;
  }
}

}  // namespace
}  // namespace umov::optics
