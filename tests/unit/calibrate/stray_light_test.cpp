#include "host/calibrate/stray_light.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/calibrate/synthetic_scan.hpp"

namespace umov::calibrate {
namespace {

using namespace test;

constexpr double even = 4e-4, forward = 1e-3, width_deg = 10;

Instrument bench() {
  Instrument instrument;
  instrument.stray_per_sr = [](double theta_r) {
    return even + forward * std::exp(-std::pow((90 - theta_r) / width_deg, 2) / 2);
  };
  return instrument;
}

struct Input {
  explicit Input(formats::ScanTable table) : scan(std::move(table)) {
    rows = sort_rows(scan);
    noise = fit_noise(scan);
    dark = find_dark(scan, rows, noise);
  }
  RangeInput view() const { return {&scan, &rows, &noise, &dark}; }
  formats::ScanTable scan;
  ScanRows rows;
  NoiseModel noise;
  Dark dark;
};

formats::ScanTable campaign_scan(const Instrument& instrument, std::uint64_t seed, bool shutter) {
  formats::ScanTable scan = make_scan(instrument, lambertian(0.5), Plan{}, seed);
  Plan empty;
  empty.states = {{0, open_axis}, {0, 0}};
  empty.gain = 1000;
  add_no_sample(scan, instrument, empty, seed);
  if (shutter) add_closed(scan, instrument, {1000}, 40, seed);
  return scan;
}

const std::vector<StrayGain> gains = {{532, 600.0, 0.0}};

StrayLight find(const formats::ScanTable& scan, std::vector<std::string>& notes,
                double tolerance = 1e-2) {
  const Input input(scan);
  const RangeInput view = input.view();
  StrayOptions options;
  options.tolerance_per_sr = tolerance;
  return find_stray_light(std::span(&view, 1), gains, 1e-4, RangeErrors{}, options, notes);
}

TEST(StrayLight, LevelAndForwardPartAreFoundWithHonestPulls) {
  Instrument instrument = bench();
  instrument.dark_v = [](double) { return 3e-6; };
  double even_chi2 = 0, forward_chi2 = 0;
  const int seeds = 40;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    std::vector<std::string> notes;
    const StrayLight found = find(campaign_scan(instrument, seed, true), notes);
    EXPECT_TRUE(notes.empty());
    EXPECT_EQ(found.measured[0], 1);
    even_chi2 += std::pow(found.even_per_sr[0] - even, 2) / found.covariance(0, 0) / seeds;
    if (found.forward_width_deg == width_deg)
      forward_chi2 +=
          std::pow(found.forward_per_sr[0] - forward, 2) / found.covariance(1, 1) / seeds;
    // Whatever width was chosen, the level at an angle is what counts.
    const double truth = instrument.stray_per_sr(80);
    EXPECT_NEAR(found.level(532, 80, 0), truth, 5 * found.level_u(532, 80, 0) + 0.1 * forward);
  }
  RecordProperty("even_pull_chi2", std::to_string(even_chi2));
  RecordProperty("forward_pull_chi2", std::to_string(forward_chi2));
  EXPECT_GT(even_chi2, 0.5);
  EXPECT_LT(even_chi2, 1.6);
  EXPECT_LT(forward_chi2, 1.6);
}

TEST(StrayLight, WithoutAClosedShutterTheDarkSignalMayBeAllOfItAndIsSaidToBe) {
  Instrument instrument;
  instrument.dark_v = [](double) { return 3e-5; };  // no stray light at all
  formats::ScanTable scan = make_scan(instrument, lambertian(0.5), Plan{}, 4);
  Plan empty;
  empty.gain = 1000;
  add_no_sample(scan, instrument, empty, 4);
  for (double& y : scan.y_v) y += 2e-5;  // the same offset shows in quadrature
  std::vector<std::string> notes;
  const StrayLight found = find(scan, notes);
  ASSERT_EQ(notes.size(), 1U);
  EXPECT_NE(notes[0].find("cannot be told apart"), std::string::npos);
  EXPECT_NE(notes[0].find("`shutter`"), std::string::npos);
  EXPECT_LT(std::abs(found.even_per_sr[0]), 4 * std::sqrt(found.covariance(0, 0)));
}

TEST(StrayLight, PowerStepsTellItFromTheDarkSignalWithoutAShutter) {
  Instrument instrument = bench();
  instrument.dark_v = [](double) { return 3e-6; };
  formats::ScanTable scan = make_scan(instrument, lambertian(0.5), Plan{}, 6);
  Plan empty;
  empty.gain = 1000;
  for (double power : {4.0, 1.0, 0.1}) {
    Instrument dimmed = instrument;
    dimmed.power = power;
    add_no_sample(scan, dimmed, empty, 6 + static_cast<std::uint64_t>(10 * power));
  }
  std::vector<std::string> notes;
  const StrayLight found = find(scan, notes);
  EXPECT_LT(std::sqrt(found.covariance(0, 0)), 0.2 * even);
  EXPECT_NEAR(found.even_per_sr[0], even, 4 * std::sqrt(found.covariance(0, 0)));
}

TEST(StrayLight, IsAssumedZeroWithItsToleranceWhereNothingWasMeasured) {
  std::vector<std::string> notes;
  const StrayLight found = find(make_scan(bench(), lambertian(0.5), Plan{}, 2), notes, 1e-4);
  EXPECT_EQ(found.measured[0], 0);
  EXPECT_EQ(found.even_per_sr[0], 0.0);
  EXPECT_NEAR(std::sqrt(found.covariance(0, 0)), 1e-4, 1e-12);
  ASSERT_EQ(notes.size(), 1U);
  EXPECT_NE(notes[0].find("`no_sample`"), std::string::npos);
}

}  // namespace
}  // namespace umov::calibrate
