#include "host/calibrate/linearity.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/calibrate/synthetic_scan.hpp"

namespace umov::calibrate {
namespace {

using namespace test;

/// A gloss lobe, so that one line holds signals over three decades.
Brdf lobe() {
  return depolarising([](double theta_r, double) {
    return 0.02 + 15.0 * std::exp(-std::pow((theta_r - 30) / 6.0, 2));
  });
}

Instrument bench(double kappa) {
  Instrument instrument;
  instrument.kappa_per_v = kappa;
  instrument.source_relative = 2e-3;
  return instrument;
}

/// Power steps 1, .3, .1 of one line, each with its own level of drift that the monitor misses.
formats::ScanTable power_steps(const Instrument& instrument, std::uint64_t seed, double drift,
                               double gain = 0) {
  std::mt19937_64 random(seed * 7919);
  std::normal_distribution<double> normal;
  Plan plan;
  plan.theta_i = {30};
  plan.step = 3;
  plan.gain = gain;
  formats::ScanTable scan = make_scan(instrument, lobe(), plan, seed);
  int step = 0;
  for (int repeat = 0; repeat < 4; ++repeat)
    for (double power : {1.0, 0.3, 0.1}) {
      Instrument dimmed = instrument;
      dimmed.power = power;
      dimmed.gain_constant[532] *= 1.0 + drift * normal(random);
      append(scan,
             make_scan(dimmed, lobe(), plan, seed + 1000 * static_cast<std::uint64_t>(++step)),
             "nd");
    }
  return scan;
}

Linearity linearity_of(const formats::ScanTable& scan, const LinearityOptions& options = {}) {
  const ScanRows rows = sort_rows(scan);
  const NoiseModel noise = fit_noise(scan);
  const Dark dark = find_dark(scan, rows, noise);
  const RangeInput input{&scan, &rows, &noise, &dark};
  return find_linearity(std::span(&input, 1), options);
}

TEST(Linearity, KappaOfADetectorIsFoundFromPowerStepsWithHonestPulls) {
  // Truth .02 /V: signals reach .9 V, so that the strongest reads 1.8 % low.
  const Instrument instrument = bench(0.02);
  LinearityOptions options;
  options.kappa_tolerance_per_v = 0.05;
  double chi2 = 0, sum = 0;
  const int seeds = 40;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    const Linearity found = linearity_of(power_steps(instrument, seed, 0.002), options);
    EXPECT_TRUE(found.nonlinearity.measured);
    EXPECT_LT(found.nonlinearity.kappa_u_per_v, 0.009);
    const double pull = (found.nonlinearity.kappa_per_v - 0.02) / found.nonlinearity.kappa_u_per_v;
    chi2 += pull * pull / seeds;
    sum += pull / seeds;
  }
  RecordProperty("kappa_pull_chi2", std::to_string(chi2));
  RecordProperty("kappa_pull_mean", std::to_string(sum));
  EXPECT_LT(std::abs(sum), 0.5);
  EXPECT_GT(chi2, 0.55);
  EXPECT_LT(chi2, 1.6);
}

TEST(Linearity, RangesAndKappaAreToldApartInOneFit) {
  Instrument instrument = bench(0.02);
  instrument.range_error = [](double gain) {
    return gain == 10 ? 3e-3 : gain == 100 ? -4e-3 : 0.0;
  };
  LinearityOptions options;
  options.kappa_tolerance_per_v = 0.05;
  double kappa_chi2 = 0, range_chi2 = 0;
  const int seeds = 30;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    const Linearity found = linearity_of(power_steps(instrument, seed, 0.002), options);
    kappa_chi2 +=
        std::pow((found.nonlinearity.kappa_per_v - 0.02) / found.nonlinearity.kappa_u_per_v, 2) /
        seeds;
    // Chains of comparisons start at the lowest range that occurs.
    const double base = instrument.range_error(found.ranges.ranges.front().gain);
    for (double gain : {10.0, 100.0}) {
      const RangeError range = found.ranges.at(gain);
      if (!(range.u > 0)) continue;
      EXPECT_TRUE(range.measured);
      const double truth = (1 + instrument.range_error(gain)) / (1 + base) - 1;
      range_chi2 += std::pow((range.error - truth) / range.u, 2) / (2 * seeds);
    }
  }
  RecordProperty("kappa_pull_chi2", std::to_string(kappa_chi2));
  RecordProperty("range_pull_chi2", std::to_string(range_chi2));
  EXPECT_GT(kappa_chi2, 0.5);
  EXPECT_LT(kappa_chi2, 1.7);
  EXPECT_GT(range_chi2, 0.4);
  EXPECT_LT(range_chi2, 1.7);
}

TEST(Linearity, ALinearDetectorIsNotCorrectedBeyondItsUncertainty) {
  const Instrument instrument = bench(0);
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Linearity found = linearity_of(power_steps(instrument, seed, 0.002));
    EXPECT_LT(std::abs(found.nonlinearity.kappa_per_v), 3.5 * found.nonlinearity.kappa_u_per_v);
  }
}

TEST(Linearity, WithoutPowerStepsTheToleranceStandsAndASentenceSaysSo) {
  Plan plan;
  const Linearity found = linearity_of(make_scan(bench(0.02), lobe(), plan, 3));
  EXPECT_FALSE(found.nonlinearity.measured);
  EXPECT_EQ(found.nonlinearity.kappa_per_v, 0.0);
  EXPECT_DOUBLE_EQ(found.nonlinearity.kappa_u_per_v, 1e-3);
  ASSERT_FALSE(found.notes.empty());
  EXPECT_NE(found.notes[0].find("block `nd`"), std::string::npos);
}

TEST(Linearity, SlowScatterThatTheBlocksMissIsFoundFromTheResiduals) {
  Instrument instrument = bench(0);
  instrument.slow_relative = 4e-3;
  const Linearity found = linearity_of(power_steps(instrument, 5, 0.0));
  EXPECT_NEAR(found.slow_noise, 4e-3, 8e-4);
}

TEST(Linearity, DriftBetweenBlocksIsNotTakenForNonlinearity) {
  // One geometry at three powers: level and nonlinearity look the same, so kappa must stay open.
  Instrument instrument = bench(0);
  Plan plan;
  plan.theta_i = {30};
  plan.from = plan.to = 30;
  formats::ScanTable scan = make_scan(instrument, lobe(), plan, 1);
  instrument.power = 0.1;
  instrument.gain_constant[532] *= 1.004;  // the monitor missed this
  append(scan, make_scan(instrument, lobe(), plan, 2), "nd");
  const Linearity found = linearity_of(scan);
  EXPECT_FALSE(found.nonlinearity.measured);
  EXPECT_LT(std::abs(found.nonlinearity.kappa_per_v), 1.5e-3);
}

TEST(Linearity, AToleranceThatTheScansContradictIsNamed) {
  LinearityOptions options;
  options.kappa_tolerance_per_v = 1e-3;
  const Linearity found = linearity_of(power_steps(bench(0.08), 2, 0.001), options);
  ASSERT_FALSE(found.notes.empty());
  EXPECT_NE(found.notes[0].find("tolerance.nonlinearity_per_v"), std::string::npos);
}

TEST(Linearity, TrueSignalUndoesTheDetectorsLaw) {
  Nonlinearity law;
  law.kappa_per_v = 0.03;
  const double truth = 1.7;
  EXPECT_NEAR(law.true_signal(truth / (1 + 0.03 * truth)), truth, 1e-12);
}

}  // namespace
}  // namespace umov::calibrate
