#include "host/scan/record_scale.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace umov::scan {
namespace {

/// A controller of round numbers: 1 mV a code, references of amplitude 1000.
protocol::HelloReply device() {
  protocol::HelloReply hello;
  hello.adc_step_nv = 1'000'000;
  hello.sine_amplitude = 1000;
  hello.gains = {1, 10, 100, 1000};
  return hello;
}

/// 500 samples of a signal of 200 codes in phase and -50 in quadrature, monitor 300 codes.
protocol::Record record() {
  protocol::Record r;
  r.index = 17;
  r.time_us = 12'500'000;
  r.gain = 2;
  r.direction = 1;
  r.shutter_open = 1;
  r.samples = 500;
  r.signal_x = 200LL * 1000 * 500 / 2;
  r.signal_y = -50LL * 1000 * 500 / 2;
  r.signal_x_se = 2ULL * 1000 * 500 / 2;
  r.signal_y_se = 3ULL * 1000 * 500 / 2;
  r.monitor_x = 300LL * 1000 * 500 / 2;
  r.monitor_y = 40LL * 1000 * 500 / 2;
  return r;
}

PlanRow row() {
  PlanRow r;
  r.theta_i_deg = 30;
  r.theta_r_deg = -45;
  r.phi_r_deg = 10;
  r.wavelength_nm = 633;
  r.polarizer_deg = 90;
  r.analyzer_deg = 0;
  return r;
}

TEST(RecordScale, SumsBecomeVoltsReferredToRangeOne) {
  const auto scan = scaled(record(), row(), device(), 0);
  EXPECT_DOUBLE_EQ(scan.gain, 100);
  EXPECT_DOUBLE_EQ(scan.x_v, 0.200 / 100);
  EXPECT_DOUBLE_EQ(scan.y_v, -0.050 / 100);
  EXPECT_DOUBLE_EQ(scan.x_se_v, 0.002 / 100);
  EXPECT_DOUBLE_EQ(scan.y_se_v, 0.003 / 100);
}

TEST(RecordScale, EachAmplifierRangeIsDividedOut) {
  for (std::uint8_t range = 0; range < 4; ++range) {
    auto r = record();
    r.gain = range;
    const auto scan = scaled(r, row(), device(), 0);
    EXPECT_DOUBLE_EQ(scan.gain, std::pow(10, range));
    EXPECT_NEAR(scan.x_v * scan.gain, 0.200, 1e-15);
    EXPECT_DOUBLE_EQ(scan.monitor_v, 0.300) << "the monitor has no ranges";
  }
}

TEST(RecordScale, TheMonitorIsItsInPhasePartWithItsSign) {
  auto r = record();
  EXPECT_DOUBLE_EQ(scaled(r, row(), device(), 0).monitor_v, 0.300);
  r.monitor_x = -r.monitor_x;
  EXPECT_DOUBLE_EQ(scaled(r, row(), device(), 0).monitor_v, -0.300);
  r.monitor_x = 0;
  EXPECT_EQ(scaled(r, row(), device(), 0).monitor_v, 0) << "noise in quadrature is no light";
}

TEST(RecordScale, AnglesAreThoseCommandedAndOpenStaysOpen) {
  auto commanded = row();
  commanded.analyzer_deg = formats::open_axis;
  const auto scan = scaled(record(), commanded, device(), 0);
  EXPECT_EQ(scan.index, 17);
  EXPECT_EQ(scan.theta_i_deg, 30);
  EXPECT_EQ(scan.theta_r_deg, -45);
  EXPECT_EQ(scan.phi_r_deg, 10);
  EXPECT_EQ(scan.wavelength_nm, 633);
  EXPECT_EQ(scan.polarizer_deg, 90);
  EXPECT_TRUE(formats::is_open(scan.analyzer_deg));
}

TEST(RecordScale, TimeCountsFromTheStartOfTheScan) {
  EXPECT_DOUBLE_EQ(scaled(record(), row(), device(), 10'000'000).time_s, 2.5);
}

TEST(RecordScale, ADetectorThatHasNotMovedYetCountsAsMovedUpwards) {
  auto r = record();
  EXPECT_EQ(scaled(r, row(), device(), 0).direction, 1);
  r.direction = 0;
  EXPECT_EQ(scaled(r, row(), device(), 0).direction, 1);
  r.direction = -1;
  EXPECT_EQ(scaled(r, row(), device(), 0).direction, -1);
}

TEST(RecordScale, OneClippedSampleMarksTheRecord) {
  auto r = record();
  EXPECT_FALSE(scaled(r, row(), device(), 0).saturated);
  EXPECT_TRUE(scaled(r, row(), device(), 0).shutter_open);
  r.saturated = 1;
  r.shutter_open = 0;
  EXPECT_TRUE(scaled(r, row(), device(), 0).saturated);
  EXPECT_FALSE(scaled(r, row(), device(), 0).shutter_open);
}

}  // namespace
}  // namespace umov::scan
