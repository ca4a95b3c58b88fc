#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "host/brdf/dhr.hpp"
#include "host/brdf/evaluate.hpp"
#include "host/brdf/table_dhr.hpp"
#include "host/errors/error.hpp"
#include "host/formats/klems_table.hpp"
#include "host/formats/visible_band.hpp"
#include "host/optics/angles.hpp"

namespace umov::formats {
namespace {

using optics::radians;
using ::testing::HasSubstr;
constexpr double pi = std::numbers::pi;

const KlemsBasis& full() {
  static const KlemsBasis basis = *KlemsBasis::by_name("LBNL/Klems Full");
  return basis;
}

const KlemsBasis& quarter() {
  static const KlemsBasis basis = *KlemsBasis::by_name("lbnl/klems quarter");
  return basis;
}

KlemsSource source_of(const brdf::Model& model, std::vector<double> values) {
  KlemsSource source;
  source.brdf = [model, values](double theta_i, double theta_r, double phi_r) {
    return brdf::evaluate<double>(model, std::span<const double>(values), 0.55,
                                  brdf::Geometry<double>{theta_i, theta_r, phi_r})[0][0];
  };
  return source;
}

/// A painted surface with a lobe and a diffuse part that grows towards grazing.
const KlemsSource& paint() {
  static const KlemsSource source =
      source_of(brdf::Model::by_name("microfacet+nef"), {1.5, 0.0, 0.1, 1.0, 0.05, 0.005});
  return source;
}

const KlemsAverage& averaged_paint() {
  static const KlemsAverage average = klems_average(paint(), full());
  return average;
}

TEST(KlemsBasis, PatchesTileTheHemisphere) {
  const std::vector<std::pair<const char*, std::size_t>> known{
      {"LBNL/Klems Full", 145}, {"LBNL/Klems Half", 73}, {"LBNL/Klems Quarter", 41}};
  for (const auto& [name, patches] : known) {
    const KlemsBasis basis = *KlemsBasis::by_name(name);
    EXPECT_EQ(basis.size(), patches);
    double sum = 0;
    for (std::size_t p = 0; p < basis.size(); ++p) sum += basis.patch(p).projected_solid_angle();
    EXPECT_NEAR(sum, pi, 1e-12);
  }
  EXPECT_FALSE(KlemsBasis::by_name("LBNL/Klems Third"));
}

TEST(KlemsBasis, EveryPatchHoldsItsOwnCentre) {
  for (std::size_t p = 0; p < full().size(); ++p) {
    const KlemsPatch& patch = full().patch(p);
    const double theta = 0.5 * (patch.theta_lower + patch.theta_upper);
    EXPECT_EQ(full().patch_of(theta, patch.phi_centre), p);
    EXPECT_EQ(full().patch_of(theta, patch.phi_centre - 2 * pi), p);
    if (patch.phi_half_width < 3) {
      EXPECT_EQ(full().patch_of(theta, patch.phi_centre + 0.99 * patch.phi_half_width), p);
      EXPECT_NE(full().patch_of(theta, patch.phi_centre + 1.01 * patch.phi_half_width), p);
    }
  }
  EXPECT_EQ(full().patch_of(radians(10), 0), 1u) << "patch 0 of a ring is centred on azimuth 0";
}

TEST(KlemsBasis, RingsWithGapsAreRefused) {
  EXPECT_THROW(KlemsBasis("x", {{0, 10, 1}, {12, 90, 8}}), Error);
  EXPECT_THROW(KlemsBasis("x", {{0, 10, 1}, {10, 80, 8}}), Error);
  EXPECT_THROW(KlemsBasis("x", {{0, 10, 1}, {10, 90, 1'000'000}}), Error);
  EXPECT_THROW(KlemsBasis("x", {}), Error);
}

TEST(KlemsAverage, OfALambertianSurfaceIsItsBrdfEverywhere) {
  const auto average = klems_average(source_of(brdf::Model::by_name("lambertian"), {0.6}), full());
  for (const double value : average.matrix.values) EXPECT_NEAR(value, 0.6 / pi, 1e-3 * 0.6 / pi);
  for (const double dhr : directional_hemispherical(average.matrix)) EXPECT_NEAR(dhr, 0.6, 1e-4);
}

TEST(KlemsAverage, AMirrorLikeLobeLiesOnTheDiagonal) {
  const auto model = brdf::Model::by_name("microfacet");
  const auto average = klems_average(source_of(model, {1.5, 0.0, 0.03, 1.0}), full());
  EXPECT_LT(anisotropy(average.matrix), 1e-12);
  for (std::size_t i = 0; i < full().size(); ++i) {
    // At grazing incidence the lobe is wider than a patch and leans outwards.
    if (full().patch(i).theta_upper > radians(66)) continue;
    for (std::size_t o = 0; o < full().size(); ++o)
      if (o != i) {
        EXPECT_LT(average.matrix.at(o, i), average.matrix.at(i, i)) << o << " " << i;
      }
  }
}

TEST(KlemsAverage, IsTheMeanOverBothPatches) {
  // Against plain Monte Carlo, pairs near and far from the mirror.
  const KlemsSource& source = paint();
  const KlemsAverage& average = averaged_paint();
  EXPECT_LT(average.largest_relative_error, 1.5e-3);
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> unit(0, 1);
  const auto direction = [&](const KlemsPatch& patch) {
    const double low = std::pow(std::sin(patch.theta_lower), 2),
                 high = std::pow(std::sin(patch.theta_upper), 2);
    return std::pair(std::asin(std::sqrt(low + (high - low) * unit(random))),
                     patch.phi_centre + patch.phi_half_width * (2 * unit(random) - 1));
  };
  for (const auto& [o, i] : {std::pair{0u, 0u},
                             {30u, 30u},
                             {31u, 30u},
                             {50u, 30u},
                             {120u, 30u},
                             {140u, 140u},
                             {3u, 0u}}) {
    double sum = 0, squares = 0;
    constexpr int n = 40000;
    for (int s = 0; s < n; ++s) {
      const auto [theta_i, towards] = direction(full().patch(i));
      const auto [theta_r, phi] = direction(full().patch(o));
      const double f = source.brdf(theta_i, theta_r, phi - towards);
      sum += f;
      squares += f * f;
    }
    const double mean = sum / n, se = std::sqrt((squares / n - mean * mean) / n);
    EXPECT_NEAR(average.matrix.at(o, i), mean, 4.5 * se + 1e-3 * mean) << o << " " << i;
  }
}

TEST(KlemsAverage, KeepsTheReflectanceOfTheSource) {
  const auto model = brdf::Model::by_name("microfacet+nef");
  const std::vector<double> values{1.5, 0.0, 0.1, 1.0, 0.05, 0.005};
  const auto dhr = directional_hemispherical(averaged_paint().matrix);
  for (std::size_t r = 0; r + 1 < full().rings().size(); ++r) {
    const KlemsPatch& patch = full().patch(full().first_of(r));
    double mean = 0;
    constexpr int steps = 40;
    const double low = std::pow(std::sin(patch.theta_lower), 2),
                 high = std::pow(std::sin(patch.theta_upper), 2);
    for (int s = 0; s < steps; ++s)
      mean += brdf::dhr(model, values, 0.55,
                        std::asin(std::sqrt(low + (high - low) * (s + 0.5) / steps)))
                  .unpolarized /
              steps;
    EXPECT_NEAR(dhr[full().first_of(r)], mean, 1e-3 * mean) << "ring " << r;
  }
}

TEST(KlemsAverage, PutsAnExactMirrorOnTheDiagonal) {
  KlemsSource source;
  source.brdf = [](double, double, double) { return 0.0; };
  source.mirror = [](double) { return 0.5; };
  const auto average = klems_average(source, quarter());
  for (const double dhr : directional_hemispherical(average.matrix)) EXPECT_NEAR(dhr, 0.5, 1e-12);
  EXPECT_EQ(average.matrix.at(3, 5), 0);
}

TEST(KlemsAverage, RefusesASourceThatIsNoBrdf) {
  KlemsSource source;
  source.brdf = [](double theta_i, double, double) { return theta_i > 1 ? std::nan("") : 0.1; };
  EXPECT_THROW(klems_average(source, quarter()), Error);
}

TEST(KlemsTable, ForwardIsTheSpecularSide) {
  const KlemsTable table(averaged_paint().matrix, "Visible", 0.555, "test");
  const double forward = table.at(0.555, {radians(40), radians(40), 0.0})[0][0];
  const double retro = table.at(0.555, {radians(40), radians(40), pi})[0][0];
  const double signed_retro = table.at(0.555, {radians(40), -radians(40), 0.0})[0][0];
  EXPECT_GT(forward, 5 * retro);
  EXPECT_EQ(retro, signed_retro);
  EXPECT_EQ(table.at(0.555, {radians(40), radians(90.5), 0.0})[0][0], 0);
}

TEST(KlemsTable, ReflectsWhatItsPatchesDo) {
  const auto dhr = directional_hemispherical(averaged_paint().matrix);
  const KlemsTable table(averaged_paint().matrix, "Visible", 0.555, "test");
  for (const double theta_deg : {2.0, 40.0, 80.0}) {
    const auto integral = brdf::integrate_table(table, 0.555, radians(theta_deg));
    const std::size_t patch = full().patch_of(radians(theta_deg), 0);
    EXPECT_NEAR(integral.value[0], dhr[patch], 1e-6 * dhr[patch]) << theta_deg;
  }
}

TEST(KlemsTable, AnAnisotropicSurfaceIsRefused) {
  auto average =
      klems_average(source_of(brdf::Model::by_name("microfacet"), {1.5, 0.0, 0.2, 1.0}), quarter());
  EXPECT_NO_THROW(KlemsTable(average.matrix, "Visible", 0.555, "test"));
  // Brushed metal: the light of half the azimuths goes astray.
  for (std::size_t i = 0; i < quarter().size(); ++i)
    for (std::size_t o = 0; o < quarter().size(); ++o)
      average.matrix.at(o, i) *= 1 + 0.9 * std::cos(2 * quarter().patch(i).phi_centre);
  try {
    KlemsTable(average.matrix, "Visible", 0.555, "test");
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("not isotropic"));
  }
}

TEST(VisibleBand, SharesFollowTheEye) {
  const std::vector<double> lasers{0.532, 0.633, 0.814};
  const auto shares = visible_shares(lasers);
  EXPECT_NEAR(shares[0] + shares[1] + shares[2], 1, 1e-12);
  EXPECT_GT(shares[0], 0.6);
  EXPECT_GT(shares[1], 0.2);
  EXPECT_LT(shares[2], 0.01);
  EXPECT_EQ(visible_shares(std::vector<double>{1.06}).front(), 1);
  // The mean wavelength of daylight seen by the eye.
  std::vector<double> fine;
  for (int n = 0; n <= 60; ++n) fine.push_back(0.400 + 0.005 * n);
  const auto fine_shares = visible_shares(fine);
  double mean = 0;
  for (std::size_t n = 0; n < fine.size(); ++n) mean += fine_shares[n] * fine[n];
  EXPECT_NEAR(mean, 0.559, 0.003);
}

}  // namespace
}  // namespace umov::formats
