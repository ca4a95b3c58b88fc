// Tables in two planes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <memory>

#include "host/brdf/checks.hpp"
#include "host/brdf/dhr.hpp"
#include "host/brdf/evaluate.hpp"
#include "host/brdf/planes_table.hpp"
#include "host/errors/error.hpp"
#include "tests/unit/brdf/table_source.hpp"

namespace umov::brdf {
namespace {

using optics::element;
using optics::Mueller;
using optics::radians;
using ::testing::HasSubstr;

/// What `f` would give if measured in both planes.
PlanesAtIncidence measured(double theta_i, const std::vector<double>& theta_r,
                           const std::vector<double>& beta,
                           const std::function<double(const Geometry<double>&)>& f) {
  PlanesAtIncidence slice{theta_i, {theta_r, {{}}}, {beta, {{}}}};
  for (const double r : theta_r) slice.in_plane.brdf_per_sr[0].push_back(f(degrees(theta_i, r, 0)));
  for (const double b : beta) {
    const double along = std::cos(radians(b));
    const double x = along * std::sin(radians(theta_i)), y = std::sin(radians(b));
    slice.across.brdf_per_sr[0].push_back(
        f({radians(theta_i), std::acos(along * std::cos(radians(theta_i))), std::atan2(y, x)}));
  }
  return slice;
}

PlanesTable measured_planes(const std::function<double(const Geometry<double>&)>& f,
                            double step = 5.0) {
  std::vector<PlanesAtIncidence> slices;
  for (const double i : {5.0, 25.0, 45.0, 60.0, 70.0, 80.0}) {
    slices.push_back(measured(i, steps(-85, 85, step), steps(0, 85, step), f));
  }
  return PlanesTable({0.633}, std::move(slices), "planes");
}

double m00(const Table& table, const Geometry<double>& g) {
  return element(table.at(0.633, g), 0, 0);
}

TEST(PlanesTable, GivesItsEntriesInBothPlanes) {
  const auto f = [](const Geometry<double>& g) { return element(source(g), 0, 0); };
  const PlanesTable table = measured_planes(f);
  for (const double i : {5.0, 25.0, 60.0}) {
    for (const double r : {-70.0, -5.0, 0.0, 25.0, 80.0}) {
      EXPECT_NEAR(m00(table, degrees(i, r, 0)), f(degrees(i, r, 0)), 1e-12);
    }
    for (const double beta : {0.0, 20.0, 85.0, -20.0}) {
      const double along = std::cos(radians(beta));
      const Geometry<double> g{radians(i), std::acos(along * std::cos(radians(i))),
                               std::atan2(std::sin(radians(beta)), along * std::sin(radians(i)))};
      EXPECT_NEAR(m00(table, g), f(g), 1e-12) << i << " " << beta;
    }
  }
}

TEST(PlanesTable, ReproducesLightThatDependsOnTheFacetsTiltOnly) {
  const auto f = [](const Geometry<double>& g) {
    return 0.2 + std::exp(-3.0 * facet_frame(g).tan2_h);
  };
  const PlanesTable table = measured_planes(f, 1.0);
  for (const double i : {25.0, 35.0, 52.0, 65.0}) {  // between incidences as well
    for (const double r : {5.0, 30.0, 60.0}) {
      for (const double p : {10.0, 60.0, 130.0, -75.0}) {
        EXPECT_NEAR(m00(table, degrees(i, r, p)), f(degrees(i, r, p)), 5e-4)
            << i << " " << r << " " << p;
      }
    }
  }
}

TEST(PlanesTable, GivesAGlossySurfacesReflectanceBackUpToItsGrazingLobe) {
  const auto f = [](const Geometry<double>& g) { return element(source(g), 0, 0); };
  const Model model = Model::by_name("tabulated")
                          .with_table(std::make_shared<PlanesTable>(measured_planes(f, 1.0)));
  const auto excess = [&](double theta_i_deg) {
    const double theta = radians(theta_i_deg);
    return dhr(model, {}, 0.633, theta).unpolarized /
               dhr(source_model, source_values, 0.633, theta).unpolarized -
           1.0;
  };
  EXPECT_NEAR(excess(5.0), 0.0, 0.001);
  EXPECT_NEAR(excess(25.0), 0.0, 0.003);
  EXPECT_NEAR(excess(45.0), 0.0, 0.02);
  EXPECT_NEAR(excess(60.0), 0.0, 0.04);
}

TEST(PlanesTable, IsContinuousThroughTheMirrorDirectionEvenWherePlanesDisagree) {
  const PlanesTable table(
      {0.633}, {{30, {{-60, 0, 30, 60}, {{0.2, 0.3, 1.0, 0.4}}}, {{0, 40}, {{2.0, 0.3}}}}},
      "planes");
  const double centre = m00(table, degrees(30, 30, 0));
  EXPECT_NEAR(centre, 1.5, 1e-12);
  for (int k = 0; k < 12; ++k) {
    const double psi = 0.5 * k, alpha = 1e-7;
    EXPECT_NEAR(
        m00(table, {radians(30) + alpha * std::cos(psi), radians(30), 2.0 * alpha * std::sin(psi)}),
        centre, 1e-5);
  }
  // A peak that only the plane across has met is in both.
  const PlanesTable coarse(
      {0.633}, {{25, {{-80, 0, 20, 40}, {{0.2, 0.3, 0.4, 0.4}}}, {{0, 10}, {{5.0, 0.3}}}}},
      "planes");
  EXPECT_NEAR(m00(coarse, degrees(25, 25, 0)), 5.0, 1e-12);
  EXPECT_EQ(coarse.incidences()[0].in_plane.deg.size(), 4u);
}

TEST(PlanesTable, NeverExceedsTheValuesItWasGiven) {
  const auto f = [](const Geometry<double>& g) { return element(source(g), 0, 0); };
  const PlanesTable table = measured_planes(f);
  double highest = 0.0;
  for (const PlanesAtIncidence& slice : table.incidences()) {
    for (const PlaneProfile* profile : {&slice.in_plane, &slice.across}) {
      for (const double v : profile->brdf_per_sr[0]) highest = std::max(highest, v);
    }
  }
  for (double i = 0; i < 90; i += 7) {
    for (double r = 0; r < 90; r += 6) {
      for (double p = -180; p <= 180; p += 20) {
        const double v = m00(table, degrees(i, r, p));
        EXPECT_GT(v, 0.0);
        EXPECT_LE(v, highest * (1.0 + 1e-12));
      }
    }
  }
}

TEST(PlanesTable, KeepsTheReflectanceOfALambertianSurfaceAndItsReciprocity) {
  const PlanesTable white =
      measured_planes([](const Geometry<double>&) { return 0.984 / optics::pi; });
  const Model model = Model::by_name("tabulated").with_table(std::make_shared<PlanesTable>(white));
  for (const double theta : {0.0, 33.0, 85.0}) {
    const Dhr d = dhr(model, {}, 0.633, radians(theta));
    EXPECT_NEAR(d.unpolarized, 0.984, std::max(d.accuracy, 3e-5)) << theta;
  }
  EXPECT_LT(reciprocity_violation(model, {}, 0.633, 200).amount, 1e-12);
  const PlanesTable glossy =
      measured_planes([](const Geometry<double>& g) { return element(source(g), 0, 0); });
  const Model other = Model::by_name("tabulated").with_table(std::make_shared<PlanesTable>(glossy));
  EXPECT_GT(reciprocity_violation(other, {}, 0.633, 200).amount, 0.05);
}

TEST(PlanesTable, RefusesBrokenProfilesWithThePlace) {
  const PlanesAtIncidence good{30, {{-60, 0, 60}, {{0.2, 0.3, 0.4}}}, {{0, 40}, {{0.5, 0.3}}}};
  const auto refusal = [&](const std::function<void(PlanesAtIncidence&)>& spoil) {
    PlanesAtIncidence slice = good;
    spoil(slice);
    return message([&] { PlanesTable({0.633}, {slice}, "planes.h5"); });
  };
  EXPECT_EQ(refusal([](auto&) {}), "no error");
  EXPECT_THAT(refusal([](auto& s) { s.in_plane.deg[1] = -70; }),
              HasSubstr("in_plane at theta_i_deg 30.deg[1]"));
  EXPECT_THAT(refusal([](auto& s) { s.across.brdf_per_sr[0][1] = std::nan(""); }),
              HasSubstr("across at theta_i_deg 30[0][1]"));
  EXPECT_THAT(refusal([](auto& s) { s.across.brdf_per_sr[0].push_back(1); }),
              HasSubstr("3 values"));
  EXPECT_THAT(refusal([](auto& s) { s.in_plane.brdf_per_sr.clear(); }),
              HasSubstr("0 wavelengths of 1"));
  EXPECT_THAT(refusal([](auto& s) { s.theta_i_deg = 95; }), HasSubstr("theta_i_deg[0]"));
  EXPECT_THROW(PlanesTable({0.633}, {}, "planes.h5"), Error);
  EXPECT_THROW(PlanesTable({0.633}, {good, good}, "planes.h5"), Error);
}

}  // namespace
}  // namespace umov::brdf
