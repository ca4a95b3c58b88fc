#include "host/calibrate/dhr.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "host/calibrate/reduce.hpp"
#include "tests/unit/calibrate/synthetic_scan.hpp"

namespace umov::calibrate {
namespace {

using namespace test;

/// A noiseless in-plane table at normal incidence.
formats::BrdfTable table_of(const Brdf& f, const Plan& plan, double relative_u = 1e-4) {
  formats::BrdfTable table;
  auto& p = table.points;
  for (const auto& [polarizer, analyzer] : plan.states)
    for (double t = plan.from; t <= plan.to + 1e-9; t += plan.step) {
      p.theta_i_deg.push_back(plan.theta_i[0]);
      p.theta_r_deg.push_back(t);
      p.phi_r_deg.push_back(0);
      p.wavelength_nm.push_back(532);
      p.polarizer_deg.push_back(polarizer);
      p.analyzer_deg.push_back(analyzer);
      p.brdf_per_sr.push_back(f(0, t, 532, polarizer, analyzer));
      p.brdf_u.push_back(relative_u * p.brdf_per_sr.back());
      p.used.push_back(1);
    }
  return table;
}

TEST(Dhr, OfALambertianIsItsReflectance) {
  Plan plan;
  plan.step = 2;
  auto table = table_of(lambertian(0.7), plan);
  const auto detail = add_dhr(table);
  ASSERT_EQ(detail.size(), 1U);
  EXPECT_NEAR(detail[0].dhr, 0.7, 1e-12);
  EXPECT_NEAR(detail[0].extrapolation, 0.7 * std::pow(std::cos(84 * degree), 2), 1e-9);
  EXPECT_LT(detail[0].u(), 0.002);
  EXPECT_EQ(table.dhr.dhr.size(), 1U);
}

TEST(Dhr, AGapOfUnusablePointsAboutTheNormalIsBridgedWithAnUncertainty) {
  for (double n : {0.0, 10.0, 300.0}) {
    Plan plan;
    plan.step = 2;
    const auto lobe = depolarising(
        [n](double t, double) { return 0.1 + 0.5 * std::pow(std::cos(t * degree), n); });
    auto whole = table_of(lobe, plan);
    auto table = whole;
    for (std::size_t i = 0; i < table.points.size(); ++i)
      if (std::abs(table.points.theta_r_deg[i]) < 4) table.points.used[i] = 0;
    const double truth = add_dhr(whole).at(0).dhr;
    EXPECT_EQ(add_dhr(whole).at(0).gap_deg, 0);
    const DhrDetail detail = add_dhr(table).at(0);
    // Nodes lie at odd or even angles, so the gap is as wide as the first used ones.
    EXPECT_GT(detail.gap_deg, 3.9) << n;
    EXPECT_LT(detail.gap_deg, 6.1) << n;
    EXPECT_LT(std::abs(detail.dhr - truth), 2 * detail.gap_u + 1e-6) << n;
    EXPECT_LT(detail.gap_u, 0.05 * truth) << n;
  }
}

TEST(Dhr, OfACosinePowerLobeMatchesTheClosedForm) {
  // f = k cos^n: the integral is 2 pi k/(n + 2). n = 100 is a lobe of 8 degrees width.
  for (double n : {1.0, 10.0, 100.0}) {
    Plan plan;
    plan.step = 2;
    auto table = table_of(
        depolarising([n](double t, double) { return 0.5 * std::pow(std::cos(t * degree), n); }),
        plan);
    const auto detail = add_dhr(table);
    const double truth = 2 * std::numbers::pi * 0.5 / (n + 2);
    EXPECT_NEAR(detail[0].dhr / truth, 1, 2e-3) << n;
    EXPECT_LT(std::abs(detail[0].dhr - truth), 2 * detail[0].u() + 1e-4 * truth) << n;
  }
}

TEST(Dhr, CoarseStepsAndAShortReachWidenTheStatedUncertainty) {
  const auto lobe =
      depolarising([](double t, double) { return 0.1 + 3 * std::exp(-0.5 * std::pow(t / 5, 2)); });
  Plan fine, coarse, shorter;
  fine.step = 1;
  coarse.step = 6;
  shorter.step = 1;
  shorter.from = -66;
  shorter.to = 66;
  auto a = table_of(lobe, fine), b = table_of(lobe, coarse), c = table_of(lobe, shorter);
  const auto fine_detail = add_dhr(a), coarse_detail = add_dhr(b), short_detail = add_dhr(c);
  EXPECT_GT(coarse_detail[0].quadrature_u, 10 * fine_detail[0].quadrature_u);
  EXPECT_LT(std::abs(coarse_detail[0].dhr - fine_detail[0].dhr), 2 * coarse_detail[0].u());
  EXPECT_GT(short_detail[0].extrapolation_u, 5 * fine_detail[0].extrapolation_u);
  EXPECT_LT(std::abs(short_detail[0].dhr - fine_detail[0].dhr), 2 * short_detail[0].u());
}

TEST(Dhr, PolarisedStatesAverageToUnpolarisedIncidence) {
  const auto sample = polarising([](double t) { return 0.2 + 0.001 * std::abs(t); }, 0.1, 0.1, 0.6);
  Plan open, both, only_p;
  open.step = both.step = only_p.step = 2;
  both.states = {{0, 0}, {0, 90}, {90, open_axis}};
  only_p.states = {{0, open_axis}};
  auto a = table_of(sample, open), b = table_of(sample, both), c = table_of(sample, only_p);
  const auto da = add_dhr(a), db = add_dhr(b), dc = add_dhr(c);
  EXPECT_NEAR(da[0].dhr, db[0].dhr, 1e-9);
  EXPECT_EQ(da[0].polarisation_u, 0);
  EXPECT_EQ(db[0].polarisation_u, 0);
  EXPECT_GT(dc[0].polarisation_u, 0.01 * dc[0].dhr);
  EXPECT_EQ(dc[0].states, "P incidence only");
}

TEST(Dhr, OneSideOfTheNormalIsEnough) {
  Plan plan;
  plan.step = 2;
  plan.from = 0;
  auto table = table_of(
      depolarising([](double t, double) { return 0.5 * std::pow(std::cos(t * degree), 10); }),
      plan);
  EXPECT_NEAR(add_dhr(table)[0].dhr, std::numbers::pi / 12, 5e-4);
}

TEST(Dhr, ObliqueIncidenceFlaggedPointsAndShortScansGiveNone) {
  Plan plan;
  plan.step = 2;
  plan.theta_i = {30};
  auto oblique = table_of(lambertian(0.5), plan);
  EXPECT_TRUE(add_dhr(oblique).empty());
  plan.theta_i = {0};
  auto flagged = table_of(lambertian(0.5), plan);
  flagged.points.used.assign(flagged.points.size(), 0);
  EXPECT_TRUE(add_dhr(flagged).empty());
  plan.from = -40;
  plan.to = 40;
  auto narrow = table_of(lambertian(0.5), plan);
  EXPECT_TRUE(add_dhr(narrow).empty());
}

TEST(Dhr, SharedFactorsAddCoherently) {
  Plan plan;
  plan.step = 2;
  auto table = table_of(lambertian(0.7), plan);
  formats::BrdfTable::Factor gain{"gain 532 nm", table.points.brdf_per_sr};
  for (double& f : gain.per_point) f *= 0.01;
  table.factors.push_back(gain);
  EXPECT_NEAR(add_dhr(table)[0].shared_u, 0.007, 1e-4);
}

TEST(Dhr, FromScanToReflectanceTheUncertaintyIsHonest) {
  Instrument instrument;
  instrument.relative = 0.004;
  Plan plan;
  plan.step = 3;
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  double square = 0;
  const int seeds = 60;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    auto white = make_white(instrument, 0.9, plan, seed, 0.004);
    white.set_key("reference_dhr_532", std::to_string(0.9 + 0.004 * normal(random)));
    const StandardScan standard{white, ReferenceStandard::from_keys(white), "white", ""};
    const auto calibration = calibrate(std::span(&standard, 1));
    const auto table =
        reduce(make_scan(instrument, lambertian(0.4), plan, seed + 700), calibration).table;
    square += std::pow((table.dhr.dhr.at(0) - 0.4) / table.dhr.dhr_u[0], 2) / seeds;
  }
  RecordProperty("dhr_pull_variance", std::to_string(square));
  EXPECT_GT(square, 0.5);
  EXPECT_LT(square, 1.4);
}

}  // namespace
}  // namespace umov::calibrate
