// A dirty surface against the mixture of its materials.
#include "host/surface/mixture_run.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "host/errors/error.hpp"
#include "host/optics/angles.hpp"
#include "host/surface/hidden_shares.hpp"

namespace umov::surface {
namespace {

using optics::radians;

std::function<Surface(const Reading&)> scene(const std::string& text) {
  return [text](const Reading& reading) { return surface_from_toml(text, "scene.toml", reading); };
}

const std::string spheres =
    "[surface]\nwavelengths_um = [0.5, 0.8]\nperiod_um = 1000\n"
    "[substrate]\nmodel = \"lambertian\"\nrho = 0.02\n"
    "[[particles]]\nmaterial = \"clay\"\nradius_um = 20\ncoverage = 0.4\nlayout = \"grid\"\n"
    "[materials.clay]\nmodel = \"lambertian\"\nrho = [0.5, 0.02]\n";

MixtureRequest request(std::vector<double> theta) {
  MixtureRequest r;
  r.theta_i_deg = std::move(theta);
  r.coverage_factors = {0.25, 0.5, 1.0};
  r.how.samples = 1 << 16;
  r.rings = 6;
  r.strip = 0;
  return r;
}

TEST(HiddenShares, AreTheShadowsOfSpheres) {
  const Surface s = scene(spheres)({});
  trace::Request how;
  how.samples = 1 << 17;
  const auto above = hidden_shares(scene(spheres), {}, 0.0, how, 0);
  ASSERT_EQ(above.size(), 1u);
  EXPECT_NEAR(above[0].mean, s.covered, 4.0 * above[0].error + 1e-4);
  // A disc of the sphere is seen from aside too: shadows grow as 1/cos θ until they meet others.
  const auto aside = hidden_shares(scene(spheres), {}, 40.0, how, 0);
  EXPECT_GT(aside[0].mean, s.covered);
  EXPECT_LT(aside[0].mean, s.covered / std::cos(radians(40.0)) + 4.0 * aside[0].error);
  Reading sparse;
  sparse.coverage_scale = 0.1;
  const Surface few = scene(spheres)(sparse);
  EXPECT_NEAR(hidden_shares(scene(spheres), sparse, 40.0, how, 0)[0].mean,
              few.covered / std::cos(radians(40.0)), 0.002);
}

TEST(Mixture, OfBrightSpheresOnBlackIsFoundWithItsLaw) {
  const auto angles = analyse_mixture(scene(spheres), request({20.0, 60.0}));
  ASSERT_EQ(angles.size(), 2u);
  for (const MixtureAngle& angle : angles) {
    ASSERT_EQ(angle.points.size(), 3u);
    for (const MixturePoint& p : angle.points) {
      const MixtureBand& band = p.bands[0];
      EXPECT_NEAR(band.linear_dhr.mean, 0.02 + p.fraction.mean * 0.48, 4e-4) << "but for roulette";
      EXPECT_NEAR(band.effective.mean, (band.dhr.mean - 0.02) / 0.48, 1e-3);
      EXPECT_NEAR(p.effective.mean, band.effective.mean, 1e-12) << "the other band has no contrast";
      EXPECT_TRUE(std::isnan(p.bands[1].effective.mean));
      EXPECT_LT(p.effective.mean, p.fraction.mean)
          << "black ground takes half of what leaves a sphere downwards";
      EXPECT_GT(p.effective.error, 0.0);
      EXPECT_LT(p.effective.error, 0.01);
      EXPECT_GT(band.shape_difference, 0.1) << "spheres are brighter towards the light";
    }
    EXPECT_EQ(angle.law.points, 3);
    EXPECT_LT(angle.law.gamma, 1.0);
    EXPECT_LT(angle.law.largest_miss, 0.03);
    EXPECT_EQ(angle.band_laws[1].points, 0);
  }
  EXPECT_THROW(analyse_mixture(scene("[surface]\nwavelengths_um = 0.5\n[substrate]\n"
                                     "model = \"lambertian\"\nrho = 0.5\n"),
                               request({0.0})),
               Error);
}

TEST(MixingLaw, IsFoundFromItsOwnPoints) {
  std::vector<trace::Estimate> f;
  std::vector<EffectiveFraction> effective;
  for (const double x : {0.05, 0.1, 0.3, 0.5, 0.8}) {
    f.push_back({x, 1e-4});
    effective.push_back({{1.0 - std::pow(1.0 - x, 1.7), 2e-3}, 2e-3});
  }
  effective[1].mean += 2e-3;
  const MixingLaw law = fit_law(f, effective);
  EXPECT_NEAR(law.gamma, 1.7, 3.0 * law.gamma_u);
  EXPECT_LT(law.gamma_u, 0.02);
  EXPECT_NEAR(law.chi2, 1.0, 0.3);
  EXPECT_NEAR(law(0.5), 1.0 - std::pow(0.5, law.gamma), 1e-15);
}

TEST(MixingLaw, HoldsWhatIsCommonToAllPoints) {
  // The bare surface one error brighter moves all points together: γ must say so.
  constexpr double by_bare = 0.01, own = 1e-4;
  const auto points = [&](double shift) {
    std::vector<EffectiveFraction> all;
    for (const double x : {0.05, 0.1, 0.3, 0.5, 0.8}) {
      const double e = 1.0 - std::pow(1.0 - x, 1.7);
      all.push_back({{e + shift * (e - 1.0) * by_bare, 0.0}, own, (e - 1.0) * by_bare, 0.0});
    }
    return all;
  };
  std::vector<trace::Estimate> f;
  for (const double x : {0.05, 0.1, 0.3, 0.5, 0.8}) f.push_back({x, 0.0});
  const MixingLaw law = fit_law(f, points(0.0));
  const double moved = std::abs(fit_law(f, points(0.1)).gamma - law.gamma) / 0.1;
  EXPECT_NEAR(law.gamma_u, moved, 0.05 * moved);
}

TEST(MixingLaw, IsNoneWherePointsFollowNone) {
  // Effective fractions beyond 1 at all coverages, as where materials hardly differ: no γ is large
  // enough.
  std::vector<trace::Estimate> f;
  std::vector<EffectiveFraction> effective;
  for (const double x : {0.05, 0.1, 0.3}) {
    f.push_back({x, 1e-3});
    effective.push_back({{6.0, 0.5}, 0.5});
  }
  EXPECT_EQ(fit_law(f, effective).points, 0);
}

TEST(Mixture, OfNothingHiddenIsTheBareSurface) {
  const auto angles = analyse_mixture(scene(spheres), request({20.0}));
  const MixtureAngle& angle = angles.at(0);
  const MixturePoint p =
      mixed(angle.wholes.at(0), angle.bare, {&angle.contaminants.at(0)}, {{0.0, 0.0}}, {0.5, 0.8});
  EXPECT_EQ(p.fraction.mean, 0.0);
  EXPECT_NEAR(p.bands[0].linear_dhr.mean, 0.02, 1e-3);
}

}  // namespace
}  // namespace umov::surface
