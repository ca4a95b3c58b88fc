#include "host/calibrate/reciprocity.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "host/calibrate/reference_standard.hpp"
#include "tests/unit/calibrate/synthetic_scan.hpp"

namespace umov::calibrate {
namespace {

using namespace test;
using formats::BrdfTable;

/// A BRDF of signed in-plane angles and states.
using InPlane =
    std::function<double(double theta_i, double theta_r, double polarizer, double analyzer)>;

BrdfTable table_of(const InPlane& f, const std::vector<std::pair<double, double>>& states,
                   double noise, std::uint64_t seed,
                   const std::vector<double>& incidences = {0, 15, 30, 45, 60}) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  BrdfTable table;
  auto& p = table.points;
  for (double wavelength : {532.0, 633.0})
    for (double theta_i : incidences)
      for (const auto& [polarizer, analyzer] : states)
        for (double theta_r = -75; theta_r <= 75; theta_r += 15) {
          const double value = f(theta_i, theta_r, polarizer, analyzer);
          p.theta_i_deg.push_back(theta_i);
          p.theta_r_deg.push_back(theta_r);
          p.phi_r_deg.push_back(0);
          p.wavelength_nm.push_back(wavelength);
          p.polarizer_deg.push_back(polarizer);
          p.analyzer_deg.push_back(analyzer);
          p.brdf_per_sr.push_back(value * (1 + noise * normal(random)));
          p.brdf_u.push_back(noise * value);
          p.used.push_back(1);
        }
  return table;
}

const std::vector<std::pair<double, double>> crossed = {{0, 0}, {0, 90}, {90, 0}, {90, 90}};

/// Reciprocal, not Lambertian, and unlike for p to s and s to p unless the states are exchanged
/// too.
double reciprocal(double theta_i, double theta_r, double polarizer, double analyzer) {
  const double ci = std::cos(theta_i * degree), cr = std::cos(theta_r * degree);
  const double base = 0.3 * (1 - 0.2 * (1 - ci)) * (1 - 0.2 * (1 - cr));
  const double from_p_to_s = polarizer == 0 && analyzer == 90 ? ci - cr : 0.0;
  const double from_s_to_p = polarizer == 90 && analyzer == 0 ? cr - ci : 0.0;
  return base * (1 + 0.2 * (from_p_to_s + from_s_to_p));
}

TEST(Reciprocity, HoldsForAReciprocalSampleWithinItsUncertainty) {
  double chi2 = 0, mean_pull2 = 0;
  const int seeds = 20;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    const auto results = check_reciprocity(table_of(reciprocal, crossed, 0.003, seed));
    ASSERT_EQ(results.size(), 3U);  // all, and each wavelength
    const Reciprocity& all = results[0];
    EXPECT_EQ(all.pairs, results[1].pairs + results[2].pairs);
    // Incidences 15, 30, 45, 60 pair twice each, 0 with each of the others once: 16 a state.
    EXPECT_EQ(all.pairs, 2U * 4U * 16U);
    chi2 += all.chi2 / static_cast<double>(all.pairs) / seeds;
    mean_pull2 += std::pow(all.mean / all.mean_u, 2) / seeds;
    EXPECT_NEAR(all.rms, all.rms_expected, 0.25 * all.rms_expected);
    EXPECT_LT(all.mean_absolute, 0.01);
  }
  EXPECT_NEAR(chi2, 1, 0.1);
  EXPECT_GT(mean_pull2, 0.3);
  EXPECT_LT(mean_pull2, 2.0);
}

TEST(Reciprocity, ExchangesPolarisationWithTheDirections) {
  // The same light with the states left as they are would miss by up to 20 %.
  const auto table = table_of(reciprocal, {{0, 90}}, 1e-6, 1);
  EXPECT_TRUE(check_reciprocity(table).empty());  // P to S has no S to P beside it
  const auto both = check_reciprocity(table_of(reciprocal, {{0, 90}, {90, 0}}, 1e-6, 1));
  ASSERT_FALSE(both.empty());
  EXPECT_LT(std::abs(both[0].largest), 1e-5);
}

TEST(Reciprocity, ObliqueAxesTurnTheirSign) {
  // In plane U changes sign with the direction of travel: +45 to p pairs with p to -45.
  const auto f = [](double theta_i, double theta_r, double polarizer, double analyzer) {
    const double even = 0.3 * std::cos(theta_i * degree) * std::cos(theta_r * degree);
    const double in = polarizer == 45 ? 1 : 0, out = analyzer == -45 ? 1 : 0;
    return even * (1 + 0.1 * in * std::sin(theta_i * degree) +
                   0.1 * out * std::sin(std::abs(theta_r) * degree));
  };
  const auto results = check_reciprocity(table_of(f, {{45, 0}, {0, -45}}, 1e-6, 1));
  ASSERT_FALSE(results.empty());
  EXPECT_LT(std::abs(results[0].largest), 1e-5);
}

TEST(Reciprocity, SeesASampleOrInstrumentThatBreaksIt) {
  const auto broken = [](double theta_i, double theta_r, double polarizer, double analyzer) {
    return reciprocal(theta_i, theta_r, polarizer, analyzer) *
           (1 + 0.05 * std::pow(theta_r / 60, 2));
  };
  const auto all = check_reciprocity(table_of(broken, crossed, 0.003, 4)).front();
  EXPECT_GT(all.chi2, 5.0 * static_cast<double>(all.pairs));
  EXPECT_GT(all.mean_absolute, 0.015);
  EXPECT_LT(all.mean, -5 * all.mean_u);  // the larger angle is the exit on the way back
}

TEST(Reciprocity, WhatBothPointsShareDropsOut) {
  auto table = table_of(reciprocal, crossed, 0.003, 5);
  const double without = check_reciprocity(table).front().mean_u;
  BrdfTable::Factor scale{"gain", {}};
  for (double f : table.points.brdf_per_sr) scale.per_point.push_back(0.05 * f);
  table.factors.push_back(scale);
  EXPECT_NEAR(check_reciprocity(table).front().mean_u, without, 1e-9);
}

TEST(Reciprocity, TellsHowAStandardDepartsFromLambertsLaw) {
  // As the chain has it: the standard's own fall towards grazing was taken for the instrument's.
  const double amplitude = 0.17;
  const auto reduced_as_lambertian = [&](double theta_i, double, double, double) {
    return 0.3 * (1 + amplitude * ReferenceStandard::shape(theta_i));
  };
  double pull2 = 0;
  const int seeds = 20;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    const auto found =
        find_standard_shape(table_of(reduced_as_lambertian, crossed, 0.004, seed), 0.5);
    ASSERT_TRUE(found.has_value());
    EXPECT_NEAR(found->amplitude, amplitude, 4 * found->u);
    EXPECT_LT(found->u, 0.02);
    pull2 += std::pow((found->amplitude - amplitude) / found->u, 2) / seeds;
  }
  EXPECT_LT(pull2, 1.2);
  const auto lambertian = find_standard_shape(
      table_of([](double, double, double, double) { return 0.3; }, crossed, 0.004, 3), 0.5);
  EXPECT_LT(std::abs(lambertian->amplitude), 4 * lambertian->u);
}

}  // namespace
}  // namespace umov::calibrate
