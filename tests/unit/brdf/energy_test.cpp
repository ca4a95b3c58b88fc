// Directional-hemispherical reflectance: against plain grids, against known integrals, and energy.
#include <gtest/gtest.h>

#include <cmath>

#include "host/brdf/dhr.hpp"
#include "host/brdf/evaluate.hpp"
#include "host/brdf/sampler.hpp"
#include "host/errors/error.hpp"
#include "tests/unit/brdf/sampling_statistics.hpp"
#include "tests/unit/brdf/variants.hpp"

namespace umov::brdf {
namespace {

using optics::element;
using optics::radians;

/// Midpoint rule over the hemisphere: slow, blunt, independent of the adaptive one.
double grid_dhr(const Model& model, const std::vector<double>& values, double theta_i) {
  constexpr int polar = 900, azimuthal = 360;
  double sum = 0.0;
  for (int i = 0; i < polar; ++i) {
    const double theta = (i + 0.5) * 0.5 * optics::pi / polar;
    double ring = 0.0;
    for (int j = 0; j < azimuthal; ++j) {
      const double phi = (j + 0.5) * optics::pi / azimuthal;
      ring += element(evaluate<double>(model, values, 0.633, Geometry<double>{theta_i, theta, phi}),
                      0, 0);
    }
    sum += ring * std::cos(theta) * std::sin(theta);
  }
  return sum * 2.0 * (optics::pi / azimuthal) * (0.5 * optics::pi / polar);
}

TEST(Dhr, AgreesWithAPlainGridForEveryModel) {
  for (const Variant& v : all_variants()) {
    const Model model = Model::by_name(v.name);
    const double theta_i = radians(40.0);
    const double value = dhr(model, v.values, 0.633, theta_i).unpolarized;
    EXPECT_NEAR(value, grid_dhr(model, v.values, theta_i), 3e-6) << v.name;
  }
}

TEST(Dhr, IsRightForLobesFarNarrowerThanAnyGrid) {
  // A narrow unshadowed lobe keeps the reflectance of the mirror it approaches, with a curvature of
  // order σ².
  for (const char* slopes : {"gaussian", "exponential"}) {
    const Model model = Model::by_name(std::string("microfacet:shadowing=none,slopes=") + slopes);
    for (const double degrees_i : {0.0, 45.0, 60.0}) {
      const double mirror = optics::reflectance(1.5, 0.0, std::cos(radians(degrees_i)));
      const auto excess = [&](double slope) {
        return dhr(model, std::vector{1.5, 0.0, slope, 1.0}, 0.633, radians(degrees_i))
                   .unpolarized -
               mirror;
      };
      EXPECT_NEAR(excess(0.002), 0.0, 4e-6) << degrees_i;
      EXPECT_NEAR(excess(0.02), 4.0 * excess(0.01), 2e-6 + 0.02 * std::abs(excess(0.02)))
          << degrees_i;
    }
  }
}

TEST(Dhr, OfASumIsTheSumOfDhrs) {
  const Dhr sum = dhr(Model::by_name("microfacet+nef"), std::vector{1.5, 0.0, 0.1, 1.0, 0.05, 0.01},
                      0.633, 0.7);
  const Dhr first = dhr(Model::by_name("microfacet"), std::vector{1.5, 0.0, 0.1, 1.0}, 0.633, 0.7);
  const Dhr second = dhr(Model::by_name("nef"), std::vector{0.05, 0.01}, 0.633, 0.7);
  EXPECT_NEAR(sum.unpolarized, first.unpolarized + second.unpolarized, 1e-7);
  EXPECT_NEAR(sum.s, first.s + second.unpolarized, 1e-7);
  EXPECT_NEAR(second.unpolarized, optics::pi * 0.05 + 2.0 * optics::pi * 0.01 / std::cos(0.7),
              1e-12);
}

TEST(Dhr, SeparatesSAndPAndAveragesToUnpolarised) {
  const Dhr d =
      dhr(Model::by_name("microfacet"), std::vector{1.5, 0.0, 0.1, 1.0}, 0.633, radians(56.0));
  EXPECT_GT(d.s, 10.0 * d.p);
  EXPECT_NEAR(0.5 * (d.s + d.p), d.unpolarized, 1e-15);
}

TEST(Dhr, RefusesGrazingIncidenceAndWrongParameters) {
  const Model model = Model::by_name("lambertian");
  EXPECT_THROW(dhr(model, std::vector{0.5}, 0.633, radians(90.0)), Error);
  EXPECT_THROW(dhr(model, std::vector{0.5}, 0.633, -0.1), Error);
  EXPECT_THROW(dhr(model, std::vector{1.5}, 0.633, 0.0), Error);
}

TEST(Energy, ShadowedFacetsOfAPerfectReflectorNeverGiveMoreThanTheyGet) {
  for (const char* name :
       {"microfacet:shadowing=vgroove", "microfacet", "microfacet:shadowing=smith-correlated"}) {
    for (const double slope : {0.02, 0.1, 0.3, 0.6}) {
      for (const double degrees_i : {0.0, 30.0, 60.0, 80.0}) {
        const Dhr d = dhr(Model::by_name(name), std::vector{0.05, 100.0, slope, 1.0}, 0.633,
                          radians(degrees_i));
        EXPECT_LE(d.unpolarized, 1.0 + 1e-6) << name << " slope " << slope << " at " << degrees_i;
      }
    }
  }
  for (const char* name : {"ggx", "ggx:shadowing=smith-correlated"}) {
    for (const double degrees_i : {0.0, 30.0, 60.0, 80.0}) {
      const Dhr d =
          dhr(Model::by_name(name), std::vector{0.05, 100.0, 0.3}, 0.633, radians(degrees_i));
      EXPECT_LE(d.unpolarized, 1.0 + 1e-6) << name << " at " << degrees_i;
    }
  }
}

TEST(Energy, WithoutShadowingGrazingFacetsGiveMoreThanTheyGet) {
  const Model model = Model::by_name("microfacet:shadowing=none");
  EXPECT_LT(dhr(model, std::vector{0.05, 100.0, 0.1, 1.0}, 0.633, radians(45.0)).unpolarized, 1.0);
  EXPECT_GT(dhr(model, std::vector{0.05, 100.0, 0.3, 1.0}, 0.633, radians(80.0)).unpolarized, 1.1);
}

TEST(Phong, ReflectsKsAtNormalIncidence) {
  for (const double exponent : {0.0, 1.0, 40.0, 1e5}) {
    EXPECT_NEAR(dhr(Model::by_name("phong"), std::vector{0.3, exponent}, 0.633, 0.0).unpolarized,
                0.3, 1e-6);
  }
}

TEST(Phong, ReflectsTheCosineOfIncidenceAsLongAsItsLobeClearsTheHorizon) {
  const Model model = Model::by_name("phong");
  for (const double exponent : {1e4, 1e5, 1e6}) {
    for (const double degrees_i : {30.0, 75.0, 80.0, 85.0, 87.0, 89.0, 89.5}) {
      const double cos_i = std::cos(radians(degrees_i));
      if (cos_i * std::sqrt(exponent) < 6.0) continue;
      const Dhr d = dhr(model, std::vector{0.3, exponent}, 0.633, radians(degrees_i));
      EXPECT_NEAR(d.unpolarized, 0.3 * cos_i, 1e-7) << exponent << " at " << degrees_i;
      EXPECT_LE(std::abs(d.unpolarized - 0.3 * cos_i), d.accuracy);
      EXPECT_LT(d.accuracy, 4e-6);
    }
  }
}

/// Mean of the diffuse part's weights, which knows nothing of quadrature.
void expect_drawn(const Model& model, const std::vector<double>& values, double degrees_i) {
  const Sampler sampler(model, values, 0.633);
  constexpr int count = 20000;
  double sum = 0.0, squares = 0.0;
  for (std::uint64_t i = 0; i < count; ++i) {
    const auto u = statistics::uniform(77, i);
    const auto sample = sampler.sample(radians(degrees_i), u[0], u[1], u[2]);
    if (!sample || sample->mirror) continue;
    const double weight = element(sample->weight, 0, 0);
    sum += weight;
    squares += weight * weight;
  }
  const double mean = sum / count;
  const double error = std::sqrt((squares / count - mean * mean) / count);
  const Dhr d = dhr(model, values, 0.633, radians(degrees_i));
  ASSERT_LT(error, 0.03 * mean) << model.name() << " at " << degrees_i;
  EXPECT_NEAR(d.unpolarized, mean, 4.0 * error + d.accuracy) << model.name() << " at " << degrees_i;
  EXPECT_LT(d.accuracy, 2e-6 * (1.0 + d.unpolarized));
}

TEST(Dhr, AgreesWithDrawingAtGrazingIncidence) {
  const Model he = Model::by_name("he-torrance");
  std::vector<double> rough = he.initial_values();
  rough[he.index_of("sigma_um")] = 2.0;
  rough[he.index_of("tau_um")] = 50.0;
  for (const double degrees_i : {89.9, 89.99, 89.999}) {
    expect_drawn(he, he.initial_values(), degrees_i);
    expect_drawn(he, rough, degrees_i);
  }
  for (const double degrees_i : {89.0, 89.8, 89.99}) {
    expect_drawn(Model::by_name("ward"), {0.5, 0.01, 0.5}, degrees_i);
    expect_drawn(Model::by_name("ward"), {0.5, 0.5, 0.01}, degrees_i);
  }
  expect_drawn(Model::by_name("phong"), {0.3, 1e5}, 89.9);
  expect_drawn(Model::by_name("ggx"), {0.05, 100.0, 0.02}, 89.9);
}

}  // namespace
}  // namespace umov::brdf
