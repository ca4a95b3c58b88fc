#include "host/calibrate/reduce.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "host/errors/error.hpp"
#include "tests/unit/calibrate/synthetic_scan.hpp"

namespace umov::calibrate {
namespace {

using namespace test;

const std::vector<std::pair<double, double>> paper_states = {{0, 0}, {0, 90}, {0, open_axis}};

Calibration calibrate_one(const formats::ScanTable& white) {
  const StandardScan standard{white, ReferenceStandard::from_keys(white), "white", ""};
  return calibrate(std::span(&standard, 1));
}

double lobe(double t) {
  return 0.03 + 2.5 * std::exp(-0.5 * std::pow((t - 30) / 6, 2));
}

const formats::BrdfTable::Factor* factor_named(const formats::BrdfTable& table,
                                               const std::string& name) {
  for (const auto& f : table.factors)
    if (f.name == name) return &f;
  return nullptr;
}

TEST(Reduce, IndependentUncertaintyIsWhatThePointsScatter) {
  Instrument instrument;
  const auto sample = polarising(lobe, 0.1, 0.1, 0.8);
  Plan plan;
  plan.theta_i = {30};
  plan.states = paper_states;
  plan.wavelengths = {532, 633};
  double sum = 0, square = 0, beyond = 0;
  double n = 0;
  // The truth of the calibration is given exactly: what is left is the scan's own noise.
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    auto scan = make_scan(instrument, sample, plan, seed);
    add_closed(scan, instrument, {1, 10, 100, 1000}, 400, seed);
    scan.set_key("gain_constant_532", "600");
    scan.set_key("gain_constant_633", "700");
    scan.set_key("gain_constant_relative_u", "1e-9");
    const auto table = reduce(scan, calibration_from_header(scan)).table;
    for (std::size_t i = 0; i < table.points.size(); ++i) {
      const auto& p = table.points;
      const double truth = sample(30, p.theta_r_deg[i], 532, p.polarizer_deg[i], p.analyzer_deg[i]);
      const double pull = (p.brdf_per_sr[i] - truth) / p.brdf_u[i];
      sum += pull;
      square += pull * pull;
      beyond += std::abs(pull) > 1.96;
      n += 1;
    }
  }
  RecordProperty("pull_mean", std::to_string(sum / n));
  RecordProperty("pull_variance", std::to_string(square / n));
  RecordProperty("outside_95", std::to_string(beyond / n));
  EXPECT_NEAR(sum / n, 0, 0.05);
  EXPECT_NEAR(square / n, 1, 0.06);
  EXPECT_NEAR(beyond / n, 0.05, 0.008);
}

TEST(Reduce, SharedFactorsCoverTheErrorsThatTheCalibrationBrings) {
  // The gain of a short white scan, a wrong stated reflectance, a wrong range: seen in the mean
  // over a flat sample, which has next to no noise of its own.
  Plan white_plan;
  white_plan.step = 12;
  Plan plan;
  plan.step = 2;
  double square = 0;
  const int seeds = 80;
  std::mt19937_64 random(99);
  std::normal_distribution<double> normal;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    Instrument instrument;
    instrument.relative = 0.003;
    const double e10 = 1e-3 * normal(random), e100 = 1e-3 * normal(random);
    instrument.range_error = [=](double gain) {
      return gain == 10 ? e10 : gain == 100 ? e100 : 0.0;
    };
    auto white = make_white(instrument, 0.9, white_plan, seed, 0.004);
    white.set_key("reference_dhr_532", std::to_string(0.9 + 0.004 * normal(random)));
    const auto sample = make_scan(instrument, lambertian(0.3), plan, seed + 5000);
    const auto table = reduce(sample, calibrate_one(white)).table;
    double mean = 0, variance = 0;
    const auto n = static_cast<double>(table.points.size());
    for (double f : table.points.brdf_per_sr) mean += f / n;
    for (double u : table.points.brdf_u) variance += u * u / (n * n);
    for (const auto& factor : table.factors) {
      double shift = 0;
      for (double s : factor.per_point) shift += s / n;
      variance += shift * shift;
    }
    square += std::pow(mean - 0.3 / std::numbers::pi, 2) / variance / seeds;
  }
  RecordProperty("mean_pull_variance", std::to_string(square));
  EXPECT_GT(square, 0.65);
  EXPECT_LT(square, 1.4);
}

TEST(Reduce, NonUniformInstrumentFunctionIsTakenOut) {
  Instrument instrument;
  instrument.instrument_function = [](double t) { return 1 + 0.15 * std::pow(t / 85, 4); };
  Plan plan;
  plan.step = 2;
  const auto calibration = calibrate_one(make_white(instrument, 0.99, plan, 1));
  const auto table = reduce(make_scan(instrument, lambertian(0.5), plan, 2), calibration).table;
  for (std::size_t i = 0; i < table.points.size(); ++i)
    EXPECT_NEAR(table.points.brdf_per_sr[i] * std::numbers::pi, 0.5,
                0.0025 + 5 * table.points.brdf_u[i] * std::numbers::pi);
  EXPECT_NE(factor_named(table, "gain 532 nm"), nullptr);
  EXPECT_NE(factor_named(table, "instrument function 532 nm 1"), nullptr);
}

TEST(Reduce, SaturatedRecordsAndAnglesBeyondTheStandardAreFlagged) {
  Instrument instrument;
  Plan plan;
  plan.from = -76;
  plan.to = 76;
  const auto calibration = calibrate_one(make_white(instrument, 0.99, plan, 1));
  auto scan = make_scan(instrument, lambertian(0.5), Plan{}, 2);
  scan.saturated[20] = 1;
  const Reduction result = reduce(scan, calibration);
  EXPECT_EQ(result.summary.saturated, 1U);
  EXPECT_EQ(result.summary.outside_instrument_function, 4U);
  EXPECT_EQ(result.table.points.used[20], 0);
  for (std::size_t i = 0; i < result.table.points.size(); ++i)
    if (std::abs(result.table.points.theta_r_deg[i]) > 76) {
      EXPECT_EQ(result.table.points.used[i], 0);
    }
  ReduceOptions options;
  options.extrapolate_instrument_function = true;
  EXPECT_EQ(reduce(scan, calibration, options).summary.outside_instrument_function, 0U);
}

TEST(Reduce, SignalsBelowTheNoiseAreCountedAndUsedSoThatTheirMeanIsTrue) {
  Instrument instrument;
  const auto calibration = calibrate_one(make_white(instrument, 0.99, Plan{}, 1));
  const auto dim = make_scan(instrument, lambertian(1e-6), Plan{}, 2);
  const Reduction result = reduce(dim, calibration);
  EXPECT_EQ(result.summary.points, dim.size());
  EXPECT_GT(result.summary.below_noise, dim.size() / 2);
  double sum = 0, weight = 0, negative = 0;
  for (std::size_t i = 0; i < result.table.points.size(); ++i) {
    const auto& points = result.table.points;
    EXPECT_EQ(points.used[i], 1);
    const double w = 1 / (points.brdf_u[i] * points.brdf_u[i]);
    sum += w * points.brdf_per_sr[i];
    weight += w;
    negative += points.brdf_per_sr[i] < 0 ? 1 : 0;
  }
  EXPECT_GT(negative, 0);
  EXPECT_NEAR(sum / weight, 1e-6 / std::numbers::pi, 4 / std::sqrt(weight));
}

TEST(Reduce, ABiasThatIsNotSignificantIsNoCertainZero) {
  Instrument instrument;
  Plan plan;
  plan.states = {{0, 0}, {0, 90}, {90, 90}, {90, 0}};
  const auto calibration = calibrate_one(make_white(instrument, 0.99, plan, 3));
  const auto& entry = calibration.wavelengths[0];
  ASSERT_FALSE(entry.bias_active);
  EXPECT_NEAR(entry.gain_bias_lever, 0, 0.02) << "P and S weigh the same";
  const auto table = reduce(make_scan(instrument, lambertian(0.5), plan, 4), calibration).table;
  const auto* factor = factor_named(table, "detector bias 532 nm");
  ASSERT_NE(factor, nullptr);
  for (std::size_t i = 0; i < table.points.size(); ++i) {
    const double lever = table.points.analyzer_deg[i] == 0 ? -1 : 1;
    EXPECT_NEAR(factor->per_point[i] / table.points.brdf_per_sr[i],
                -entry.detector_bias_u * (lever - entry.gain_bias_lever), 1e-12);
  }
  CalibrateOptions off;
  off.bias = CalibrateOptions::Bias::off;
  const auto white = make_white(instrument, 0.99, plan, 3);
  const StandardScan standard{white, ReferenceStandard::from_keys(white), "white", ""};
  const auto asserted = calibrate(std::span(&standard, 1), {}, off);
  EXPECT_EQ(factor_named(reduce(make_scan(instrument, lambertian(0.5), plan, 4), asserted).table,
                         "detector bias 532 nm"),
            nullptr);
}

TEST(Reduce, DarkSignalOfTheScanItselfIsSubtracted) {
  Instrument instrument;
  const auto calibration = calibrate_one(make_white(instrument, 0.99, Plan{}, 1));
  instrument.dark_v = [](double gain) { return gain == 1000 ? 2e-4 : 0.0; };
  auto scan = make_scan(instrument, lambertian(0.02), Plan{}, 2);
  const auto raw = reduce(scan, calibration).table;
  add_closed(scan, instrument, {1000}, 30, 2);
  const auto table = reduce(scan, calibration).table;
  ASSERT_EQ(table.points.size(), raw.points.size());
  const double truth = 0.02 / std::numbers::pi;
  EXPECT_GT(raw.points.brdf_per_sr[21] / truth, 1.3);
  EXPECT_NEAR(table.points.brdf_per_sr[21] / truth, 1, 0.02);
  EXPECT_NE(factor_named(table, "scan dark range 1000"), nullptr);
}

TEST(Reduce, DriftThatTheMonitorSeesAndNeutralDensityCancel) {
  Instrument instrument;
  const auto calibration = calibrate_one(make_white(instrument, 0.99, Plan{}, 1));
  auto scan = make_scan(instrument, lambertian(0.5), Plan{}, 2);
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const double power = (1 + 0.1 * static_cast<double>(i) / 40) * (i >= 30 ? 0.1 : 1.0);
    scan.x_v[i] *= power;
    scan.monitor_v[i] *= power;
  }
  scan.blocks = {
      {"main", 0, 29, {}},
      {"nd", 30, static_cast<std::int64_t>(scan.size()) - 1, {{"optical_density", "1"}}}};
  const Reduction result = reduce(scan, calibration);
  for (std::size_t i = 0; i < result.table.points.size(); ++i)
    EXPECT_NEAR(result.table.points.brdf_per_sr[i] * std::numbers::pi / 0.5, 1, 0.02);
  EXPECT_EQ(result.summary.notes.size(), 1U);
}

TEST(Reduce, RowsWithAChangedSetUpAreNoPoints) {
  Instrument instrument;
  const auto calibration = calibrate_one(make_white(instrument, 0.99, Plan{}, 1));
  auto scan = make_scan(instrument, lambertian(0.5), Plan{}, 2);
  scan.blocks = {{"main", 0, 29, {}}, {"iris", 30, 34, {{"iris_fraction", "0.5"}}}};
  const Reduction result = reduce(scan, calibration);
  EXPECT_EQ(result.summary.excluded, 5U);
  EXPECT_EQ(result.summary.points, scan.size() - 5);
  scan.blocks = {{"flip", 0, static_cast<std::int64_t>(scan.size()) - 1, {}}};
  EXPECT_THROW(reduce(scan, calibration), Error);
}

TEST(Reduce, DetectorBiasIsTakenOutOfEveryChannel) {
  Instrument instrument;
  instrument.bias = 0.04;
  Plan plan;
  plan.states = {{0, 0}, {0, 90}, {0, open_axis}, {90, 90}, {90, 0}, {90, open_axis}};
  const auto calibration = calibrate_one(make_white(instrument, 0.99, plan, 1));
  ASSERT_TRUE(calibration.wavelengths[0].bias_active);
  const auto sample = polarising([](double) { return 0.2; }, 0.2, 0.2, 0.7);
  plan.from = -60;
  plan.to = 60;
  const auto table = reduce(make_scan(instrument, sample, plan, 7), calibration).table;
  for (std::size_t i = 0; i < table.points.size(); ++i) {
    const auto& p = table.points;
    const double truth = sample(0, p.theta_r_deg[i], 532, p.polarizer_deg[i], p.analyzer_deg[i]);
    EXPECT_NEAR(p.brdf_per_sr[i] / truth, 1, 0.003 + 5 * p.brdf_u[i] / truth);
  }
}

TEST(Reduce, AScanOfAnotherSolidAngleOrWavelengthIsScaledOrRefused) {
  Instrument instrument;
  const auto calibration = calibrate_one(make_white(instrument, 0.99, Plan{}, 1));
  instrument.solid_angle_sr = 2e-4;
  auto scan = make_scan(instrument, lambertian(0.5), Plan{}, 2);
  scan.set_key("solid_angle_sr", "2e-4");
  EXPECT_NEAR(reduce(scan, calibration).table.points.brdf_per_sr[21] * std::numbers::pi, 0.5,
              0.004);
  Plan other;
  other.wavelengths = {633};
  try {
    reduce(make_scan(instrument, lambertian(0.5), other, 2), calibration);
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(error.problem().find("633"), std::string::npos);
  }
  scan.set_key("role", "dark");
  EXPECT_THROW(reduce(scan, calibration), Error);
  EXPECT_THROW(reduce(formats::ScanTable{}, calibration), Error);
}

TEST(Dolp, KnownValueIsRecoveredWithTheUncertaintyThatMonteCarloShows) {
  Instrument instrument;
  instrument.relative = 0.003;
  const auto sample = polarising(lobe, 0.1, 0.1, 0.8);
  // P incident: (PP - PS)/PU = -(m10 - m11)/(1 - m01).
  const double truth = (0.8 - 0.1) / (1 - 0.1);
  Plan plan;
  plan.theta_i = {30};
  plan.states = paper_states;
  plan.step = 6;
  double square = 0, n = 0;
  std::vector<double> at_peak;
  double stated = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    const auto calibration = calibrate_one(make_white(instrument, 0.99, Plan{}, seed, 0.05));
    const auto table = reduce(make_scan(instrument, sample, plan, seed + 900), calibration).table;
    for (std::size_t i = 0; i < table.dolp.dolp.size(); ++i) {
      square += std::pow((table.dolp.dolp[i] - truth) / table.dolp.dolp_u[i], 2);
      n += 1;
      if (table.dolp.theta_r_deg[i] == 30) {
        at_peak.push_back(table.dolp.dolp[i]);
        stated = table.dolp.dolp_u[i];
      }
    }
  }
  ASSERT_EQ(at_peak.size(), 60U);
  double mean = 0, variance = 0;
  for (double d : at_peak) mean += d / 60;
  for (double d : at_peak) variance += (d - mean) * (d - mean) / 59;
  EXPECT_NEAR(mean, truth, 0.002);
  EXPECT_NEAR(stated / std::sqrt(variance), 1, 0.35);
  EXPECT_LT(stated, 0.01) << "a 5 % reference must cancel in the ratio";
  RecordProperty("dolp_pull_variance", std::to_string(square / n));
  EXPECT_NEAR(square / n, 1, 0.25);
}

TEST(Dolp, MissingOpenChannelIsReplacedByTheSumAndSaid) {
  Instrument instrument;
  const auto sample = polarising([](double) { return 0.1; }, 0.0, 0.0, 0.5);
  const auto calibration = calibrate_one(make_white(instrument, 0.99, Plan{}, 1));
  Plan plan;
  plan.states = {{0, 0}, {0, 90}};
  const auto result = reduce(make_scan(instrument, sample, plan, 2), calibration);
  ASSERT_EQ(result.table.dolp.dolp.size(), 43U);
  EXPECT_NEAR(result.table.dolp.dolp[20], 0.5, 0.01);
  const auto& keys = result.table.keys;
  EXPECT_TRUE(std::any_of(keys.begin(), keys.end(), [](const auto& k) {
    return k.first == "dolp_denominator" && k.second == "PP + PS";
  }));
  plan.states = {{0, 0}, {0, open_axis}};
  EXPECT_TRUE(reduce(make_scan(instrument, sample, plan, 2), calibration).table.dolp.dolp.empty());
}

}  // namespace
}  // namespace umov::calibrate
