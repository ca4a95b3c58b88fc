// What is known before a diagnosis: calibration, tolerances, a fit.
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "host/errors/error.hpp"
#include "host/gap/scan/knowledge.hpp"

namespace umov::gap::scan {
namespace {

using ::testing::HasSubstr;

std::vector<Effect> effects_at(const std::vector<double>& nm) {
  Scale scale;
  scale.wavelengths_nm = nm;
  return catalogue(scale);
}

/// A calibration at 532 and 633 nm that measured a leaking polariser, and a phase that it doubts.
calibrate::Calibration leaky_calibration() {
  calibrate::Calibration calibration;
  calibration.polarization.emplace();
  for (const double nm : {532.0, 633.0}) {
    calibrate::WavelengthCalibration own;
    own.wavelength_nm = nm;
    own.gain_constant_v = 700 + nm;
    own.covariance = Eigen::MatrixXd::Constant(1, 1, 4e-6);
    own.phase_rad = 1e-4;
    own.phase_u_rad = 1e-4;
    calibration.wavelengths.push_back(own);
    calibrate::PolarizationWavelength elements;
    elements.wavelength_nm = nm;
    elements.polarizer_extinction = nm < 600 ? 0.004 : 0.002;
    elements.polarizer_extinction_u = 1e-4;
    elements.monitor_bias = 0.02;
    calibration.polarization->wavelengths.push_back(elements);
  }
  calibration.polarization->covariance = Eigen::MatrixXd::Zero(
      2 * calibrate::polarization_parameters, 2 * calibrate::polarization_parameters);
  calibration.declared.theta_r_zero_u_deg = 0.01;
  return calibration;
}

ScanRecords two_wavelengths() {
  ScanRecords records;
  records.wavelengths_nm = {532, 633};
  records.gain_constant_v = {1, 1};
  records.gain_constant_relative_u = {0.01, 0.01};
  return records;
}

TEST(Knowledge, AMeasuredLeakageIsOnFromTheStartAndMayTurnOutToBeLess) {
  ScanRecords records = two_wavelengths();
  std::vector<Effect> effects = effects_at(records.wavelengths_nm);
  std::vector<Tolerance> limits;
  const auto known = know_effects(leaky_calibration(), records, effects, limits);
  // The phase is within its doubt: it counts as none.
  ASSERT_EQ(known.size(), 1u);
  EXPECT_EQ(known[0].effect, number(EffectId::polarizer_leakage));
  EXPECT_EQ(known[0].value[0][0], 0.004);
  EXPECT_EQ(known[0].value[1][0], 0.002);
  const Parameter& extinction = effects[number(EffectId::polarizer_leakage)].parameters[0];
  EXPECT_EQ(extinction.absent, 0);
  EXPECT_EQ(extinction.lo, -0.002);
  EXPECT_EQ(extinction.prior_u, 0.1 * 3e-3);  // a tenth of what is usual: calibrations age
  EXPECT_EQ(effects[number(EffectId::detector_zero)].parameters[0].prior_u, 0.01);
  ASSERT_EQ(records.notes.size(), 1u);
  EXPECT_THAT(records.notes[0], HasSubstr("polarizer_leakage extinction 0.003"));

  std::vector<double> store;
  Switched<double> on;
  add_known(known, effects, 1, on, store);
  EXPECT_EQ(on[EffectId::polarizer_leakage][0], 0.002);
  const double beyond[] = {0.001};
  Switched<double> more;
  more.values[number(EffectId::polarizer_leakage)] = beyond;
  add_known(known, effects, 0, more, store);
  EXPECT_EQ(more[EffectId::polarizer_leakage][0], 0.005);
}

TEST(Knowledge, RecordsAreRidOfDarkSignalsAndOfWhatTheMonitorMisses) {
  ScanRecords records = two_wavelengths();
  calibrate::Calibration calibration = leaky_calibration();
  calibration.dark.levels.push_back({1, 3e-6, 1e-7, -2e-6, 1e-7, 5});
  Record r{};
  r.theta_i = 0.5;
  r.theta_r = 0.2;
  r.gain = 1;
  r.monitor_v = 2;
  r.x_v = 1e-3;
  r.polarizer = 0;  // P: Q/I = -1
  r.shutter_open = true;
  records.records = {r};
  correct_records(calibration, records);
  EXPECT_DOUBLE_EQ(records.records[0].x_v, 1e-3 - 3e-6);
  EXPECT_DOUBLE_EQ(records.records[0].y_v, 2e-6);
  EXPECT_DOUBLE_EQ(records.records[0].monitor_v, 2 / (1 - 0.02));
  EXPECT_EQ(records.gain_constant_v[1], 1333);
  EXPECT_NEAR(records.gain_constant_relative_u[0], 2e-3, 1e-12);
}

TEST(Knowledge, ATolerancesNameMustBeOneOfTheCatalogue) {
  std::vector<Effect> effects = effects_at({532});
  apply_tolerances({{"backlash", "gap_deg", 0.02, 0.04, "t.toml", 2}}, effects);
  EXPECT_EQ(effects[number(EffectId::backlash)].parameters[0].prior_u, 0.02);
  try {
    apply_tolerances({{"backlash", "play_deg", 0.02, 0.04, "t.toml", 2}}, effects);
    FAIL() << "a parameter that does not exist was taken";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("t.toml:2"));
    EXPECT_THAT(error.what(), HasSubstr("gap_deg"));
  }
}

TEST(Knowledge, AFitIsReadAtTheWavelengthsOfTheScan) {
  formats::FitResult fit;
  fit.wavelengths_nm = {532, 633, 814};
  const auto parameter = [](const char* name, bool shared, std::initializer_list<double> values) {
    formats::FitParameter p;
    p.name = name;
    p.shared = shared;
    for (const double value : values) {
      formats::Estimate estimate;
      estimate.value = value;
      p.estimates.push_back(estimate);
    }
    return p;
  };
  fit.parameters = {parameter("n", true, {1.5}), parameter("k_dd", false, {1, 2, 3})};
  const formats::FitResult at = fit_at(fit, {633.2, 814});
  ASSERT_EQ(at.parameters[1].estimates.size(), 2u);
  EXPECT_EQ(at.parameters[1].at(0).value, 2);
  EXPECT_EQ(at.parameters[1].at(1).value, 3);
  EXPECT_EQ(at.parameters[0].at(1).value, 1.5);
  EXPECT_THROW(fit_at(fit, {450}), Error);
}

TEST(Knowledge, ThinningLeavesNoAngleOut) {
  ScanRecords records;
  for (int row = 0; row < 6; ++row)
    for (int k = 0; k < 9; ++k) {
      Record r{};
      r.row = row;
      r.theta_r = k;
      records.records.push_back(r);
    }
  thin(records, 18);
  EXPECT_EQ(records.records.size(), 18u);
  std::set<double> angles;
  for (const Record& r : records.records) angles.insert(r.theta_r);
  EXPECT_EQ(angles.size(), 9u);
  EXPECT_THAT(records.notes.at(0), HasSubstr("18 of 54"));
}

}  // namespace
}  // namespace umov::gap::scan
