#include "host/calibrate/dark.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "host/calibrate/gain_range.hpp"
#include "tests/unit/calibrate/synthetic_scan.hpp"

namespace umov::calibrate {
namespace {

using namespace test;

Dark dark_of(const formats::ScanTable& scan) {
  return find_dark(scan, sort_rows(scan), fit_noise(scan));
}

TEST(Dark, LevelOfEachRangeComesFromShutterClosedRecords) {
  Instrument instrument;
  instrument.dark_v = [](double gain) { return gain == 100 ? 3e-5 : -1e-5; };
  double chi2 = 0;
  const int seeds = 60;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    auto scan = make_scan(instrument, lambertian(0.5), Plan{}, seed);
    add_closed(scan, instrument, {100, 1000}, 12, seed);
    const Dark dark = dark_of(scan);
    EXPECT_EQ(dark.at(100).records, 12U);
    chi2 += std::pow((dark.at(100).x_v - 3e-5) / dark.at(100).x_u, 2) / (2 * seeds);
    chi2 += std::pow((dark.at(1000).x_v + 1e-5) / dark.at(1000).x_u, 2) / (2 * seeds);
  }
  EXPECT_GT(chi2, 0.6);
  EXPECT_LT(chi2, 1.3);
}

TEST(Dark, WithoutClosedRecordsTheLevelIsZeroAndItsUncertaintyTheQuadratureSignal) {
  Instrument instrument;
  auto scan = make_scan(instrument, lambertian(0.5), Plan{}, 4);
  for (double& y : scan.y_v) y += 2e-4;
  const DarkLevel level = dark_of(scan).at(100);
  EXPECT_EQ(level.records, 0U);
  EXPECT_EQ(level.x_v, 0.0);
  EXPECT_NEAR(level.x_u, 2e-4, 2e-5);
}

TEST(Dark, ClosedRowsOutsideOfABlockCountAndOpenRowsInAShutterBlockDoNot) {
  Instrument instrument;
  auto scan = make_scan(instrument, lambertian(0.5), Plan{}, 4);
  scan.shutter_open[5] = 0;
  scan.blocks.push_back({"shutter", 8, 9, {}});
  const ScanRows set_up = sort_rows(scan);
  EXPECT_EQ(set_up.row[5], RowUse::closed);
  EXPECT_EQ(set_up.row[8], RowUse::changed);
  EXPECT_EQ(set_up.row[7], RowUse::plain);
}

TEST(Dark, MeasuredLevelsOfASecondScanFillGaps) {
  Dark own, other;
  own.levels = {{10, 0, 1e-6, 0, 1e-6, 0}, {100, 2e-6, 1e-7, 0, 1e-7, 5}};
  other.levels = {
      {10, 4e-6, 1e-7, 0, 1e-7, 9}, {100, 9e-6, 1e-7, 0, 1e-7, 9}, {1000, 1e-6, 1e-7, 0, 1e-7, 9}};
  const Dark merged = merge(own, other);
  EXPECT_EQ(merged.at(10).x_v, 4e-6);
  EXPECT_EQ(merged.at(100).x_v, 2e-6);
  EXPECT_EQ(merged.at(1000).x_v, 1e-6);
  EXPECT_GE(merged.at(1).x_u, 4e-6) << "a range never seen is at least as uncertain";
}

TEST(ScanRows, BlocksThatChangeTheLightPathAreLeftOut) {
  Instrument instrument;
  auto scan = make_scan(instrument, lambertian(0.5), Plan{}, 4);
  scan.blocks = {{"main", 0, 9, {}},
                 {"flip", 10, 11, {{"sample_azimuth_deg", "180"}}},
                 {"nd", 12, 13, {{"optical_density", "1"}}},
                 {"iris", 14, 15, {{"iris_fraction", "0.5"}}},
                 {"long_pass", 16, 17, {{"filter", "long_pass"}}},
                 {"no_sample", 18, 19, {{"sample_removed", "1"}}},
                 {"repeat", 20, 21, {}},
                 {"oop", 22, 22, {{"retarder_deg", "90"}}},
                 {"home_made", 23, 23, {}}};
  const ScanRows set_up = sort_rows(scan);
  for (std::size_t i : {0U, 12U, 20U, 24U}) EXPECT_EQ(set_up.row[i], RowUse::plain) << i;
  for (std::size_t i : {10U, 14U, 16U, 18U, 22U, 23U})
    EXPECT_EQ(set_up.row[i], RowUse::changed) << i;
  EXPECT_EQ(set_up.notes.size(), 7U);
}

TEST(LockinPhase, IsFoundWithinItsUncertainty) {
  Instrument instrument;
  instrument.phase_rad = 0.5 * degree;
  double chi2 = 0;
  const int seeds = 60;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    const auto scan = make_scan(instrument, lambertian(0.9), Plan{}, seed);
    const ScanRows set_up = sort_rows(scan);
    const NoiseModel noise = fit_noise(scan);
    Dark none;
    const auto phase = find_phase(scan, set_up, noise, none).at(0);
    EXPECT_GT(phase.phase_rad, 10 * phase.u_rad);
    chi2 += std::pow((phase.phase_rad - instrument.phase_rad) / phase.u_rad, 2) / seeds;
  }
  EXPECT_GT(chi2, 0.55);
  EXPECT_LT(chi2, 1.4);
}

TEST(GainRange, RatioIsFoundFromSignalsMeasuredInTwoRanges) {
  Instrument instrument;
  instrument.range_error = [](double gain) { return gain == 100 ? 0.008 : 0.0; };
  double chi2 = 0;
  const int seeds = 40;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    Plan plan;
    plan.gain = 10;
    auto scan = make_scan(instrument, lambertian(0.9), plan, seed);
    plan.gain = 100;
    const auto second = make_scan(instrument, lambertian(0.9), plan, seed + 1000);
    for (std::size_t i = 0; i < second.size(); ++i) {
      std::mt19937_64 random(seed * 7919 + i);
      add_record(scan, instrument, random, 0, second.theta_r_deg[i], 532, open_axis, open_axis, 100,
                 nominal_signal(instrument, lambertian(0.9), 0, second.theta_r_deg[i], 532,
                                open_axis, open_axis),
                 true);
    }
    const ScanRows set_up = sort_rows(scan);
    const NoiseModel noise = fit_noise(scan);
    const Dark none;
    const RangeInput input{&scan, &set_up, &noise, &none};
    const RangeErrors errors = find_range_errors(std::span(&input, 1));
    EXPECT_TRUE(errors.at(100).measured);
    EXPECT_EQ(errors.at(10).u, 0.0);
    chi2 += std::pow((errors.at(100).error - 0.008) / errors.at(100).u, 2) / seeds;
  }
  EXPECT_GT(chi2, 0.5);
  EXPECT_LT(chi2, 1.6);
}

TEST(GainRange, RangesComparedInAChainShareTheirErrors) {
  RangeErrors errors;
  errors.ranges = {{1, 0, 0, false}, {10, 0, 0, true}, {100, 0, 0, true}};
  errors.covariance = Eigen::MatrixXd::Zero(3, 3);
  // Range 10 against 1 with 1e-3, range 100 against 10 with 5e-4.
  errors.covariance(1, 1) = errors.covariance(1, 2) = errors.covariance(2, 1) = 1e-6;
  errors.covariance(2, 2) = 1e-6 + 2.5e-7;
  const Eigen::MatrixXd shifts = errors.shifts();
  EXPECT_NEAR((shifts * shifts.transpose() - errors.covariance).norm(), 0, 1e-18);
  EXPECT_NEAR(shifts(2, 1), 1e-3, 1e-12) << "the lower step moves both";
  EXPECT_NEAR(shifts(2, 2), 5e-4, 1e-12);
  EXPECT_EQ(errors.number(100), 2);
  EXPECT_EQ(errors.number(1000), -1);
}

TEST(GainRange, RangesWithoutOverlapStayNominalWithTheToleranceAsUncertainty) {
  Instrument instrument;
  const auto scan = make_scan(instrument, lambertian(0.9), Plan{}, 1);
  const ScanRows set_up = sort_rows(scan);
  const NoiseModel noise = fit_noise(scan);
  const Dark none;
  const RangeInput input{&scan, &set_up, &noise, &none};
  const RangeErrors errors = find_range_errors(std::span(&input, 1), 0.002);
  EXPECT_FALSE(errors.at(100).measured);
  EXPECT_EQ(errors.at(100).error, 0.0);
  EXPECT_NEAR(errors.at(100).u, 0.002, 1e-9);
  EXPECT_NEAR(errors.at(1).u, 0.002, 1e-9) << "never seen";
}

}  // namespace
}  // namespace umov::calibrate
