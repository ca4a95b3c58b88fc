#include "host/brdf/he_torrance.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "host/brdf/dhr.hpp"
#include "host/brdf/evaluate.hpp"

namespace umov::brdf {
namespace {

using optics::element;

/// The sum term by term in long double.
HeightSeries direct_sum(double g, double u) {
  long double value = 0, by_g = 0, by_u = 0;
  const long double last = 4.0L * g + 60.0L * std::sqrt(g) + 400.0L + 8.0L * std::sqrt(u);
  for (long double m = 1; m < last; m += 1) {
    const long double term =
        std::exp(m * std::log((long double)g) - g - std::lgamma(m + 1) - std::log(m) - u / m);
    value += term;
    by_g += term * (m / g - 1);
    by_u -= term / m;
  }
  return {(double)value, (double)by_g, (double)by_u};
}

TEST(HeightSeries, AgreesWithTheFullSumOnSmoothAndRoughSurfaces) {
  for (const double g : {1e-4, 0.1, 1.0, 5.0, 17.0, 30.0, 44.0, 46.0, 80.0, 127.0, 300.0, 3000.0}) {
    for (const double ratio : {0.0, 0.01, 1.0, 10.0, 100.0}) {
      const double u = ratio * std::max(1.0, g);
      const HeightSeries exact = direct_sum(g, u);
      const HeightSeries sum = height_series(g, u);
      EXPECT_NEAR(sum.value / exact.value, 1.0, 2e-11) << g << " " << u;
      EXPECT_NEAR(sum.by_g, exact.by_g, 1e-10 * (exact.value + std::abs(exact.by_g)))
          << g << " " << u;
      EXPECT_NEAR(sum.by_u / exact.by_u, 1.0, 2e-11) << g << " " << u;
    }
  }
}

TEST(HeightSeries, ApproachesTheFacetLimitAsOneOverG) {
  for (const double g : {100.0, 1e4, 1e6, 1e8}) {
    for (const double ratio : {0.0, 0.5, 1.0}) {
      const double u = ratio * g;
      const double limit = std::exp(-u / g) / g;
      EXPECT_NEAR(height_series(g, u).value / limit, 1.0, 3.0 / g);
    }
  }
}

TEST(HeightSeries, HasNoStepWhereTheNumberOfTermsChanges) {
  for (double g = 5.0; g < 2000.0; g *= 1.01) {
    const double u = 0.7 * g;
    const HeightSeries a = height_series(g, u);
    const HeightSeries b = height_series(g * (1.0 + 1e-6), u);
    const double expected = 0.5 * (a.by_g + b.by_g) * g * 1e-6;
    EXPECT_NEAR(b.value - a.value, expected, 2e-11 * a.value) << g;
  }
}

TEST(HeTorrance, RoughSurfaceBecomesTheGaussianFacetModel) {
  // slope s = 2σ0/τ in two dimensions, √2 σ0/τ in one; heights many waves tall.
  const std::vector<double> rough{1.5, 0.3, 60.0, 600.0};
  const std::vector<double> facets{1.5, 0.3, std::sqrt(2.0) * 0.1, 1.0};
  for (const Geometry<double>& g :
       {Geometry<double>{0.0, 0.2, 0.0}, {0.7, 0.9, 0.3}, {1.0, 0.8, 0.0}}) {
    const auto a = evaluate<double>(Model::by_name("he-torrance"), rough, 0.5, g);
    const auto b = evaluate<double>(Model::by_name("microfacet"), facets, 0.5, g);
    for (int i = 0; i < 16; ++i) {
      EXPECT_NEAR(element(a, i / 4, i % 4), element(b, i / 4, i % 4), 1e-4 * element(b, 0, 0));
    }
  }
}

TEST(HeTorrance, LightLeavesTheMirrorPartAsTheSurfaceGetsRougher) {
  const Model model = Model::by_name("he-torrance");
  const double mirror = optics::reflectance(1.5, 0.0, 1.0);
  double previous = mirror;
  for (const double sigma : {0.002, 0.01, 0.03, 0.06, 0.12}) {
    const std::vector<double> values{1.5, 0.0, sigma, 20.0};
    const double coherent = mirror_dhr(model, values, 0.633, 0.0).unpolarized;
    const double g = std::pow(4.0 * optics::pi * sigma / 0.633, 2);
    EXPECT_NEAR(coherent, mirror * std::exp(-g), 1e-12);
    EXPECT_LT(coherent, previous);
    previous = coherent;
    // For long correlation the lobe holds what the mirror part lost.
    EXPECT_NEAR(coherent + dhr(model, values, 0.633, 0.0).unpolarized, mirror, 2e-4 * mirror)
        << sigma;
  }
}

TEST(HeTorrance, OtherModelsHaveNoMirrorPart) {
  const Model model = Model::by_name("microfacet+lambertian");
  EXPECT_EQ(mirror_dhr(model, model.initial_values(), 0.633, 0.3).unpolarized, 0.0);
}

TEST(HeTorrance, VisibleMeanPlaneSolvesItsEquation) {
  for (const double c : {0.0, 1e-9, 0.1, 1.0, 10.0, 1e4}) {
    const double y = visible_plane(c);
    EXPECT_NEAR(y, c * std::exp(-0.5 * y * y), 1e-13 * (1.0 + y)) << c;
  }
}

TEST(Shadowing, SmithFactorsFallFromOneToZero) {
  EXPECT_EQ(smith_factor(11.0), 1.0);
  EXPECT_EQ(smith_factor(0.0), 0.0);
  double previous = 0.0;
  for (double x = 1e-3; x < 10.0; x *= 1.2) {
    const double lambda = 0.5 * (std::exp(-x * x) * std::numbers::inv_sqrtpi / x - std::erfc(x));
    EXPECT_NEAR(smith_factor(x), (1.0 - 0.5 * std::erfc(x)) / (1.0 + lambda), 1e-14);
    EXPECT_NEAR(smith_correlated(x, 2.0 * x),
                1.0 / (1.0 + lambda +
                       0.5 * (std::exp(-4 * x * x) * std::numbers::inv_sqrtpi / (2 * x) -
                              std::erfc(2 * x))),
                1e-14);
    EXPECT_GE(smith_factor(x), previous);
    previous = smith_factor(x);
  }
}

}  // namespace
}  // namespace umov::brdf
