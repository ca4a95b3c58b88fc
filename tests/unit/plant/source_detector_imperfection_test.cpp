// Imperfections of lasers, photodiode and electronics, each alone, by the first-order signature it
// must have.
#include <gtest/gtest.h>

#include <cmath>

#include "expected_signal.hpp"

namespace umov::plant::test {
namespace {

TEST(Photodiode, DepartsFromLinearityWithTheSignal) {
  PlantConfig config = ideal_config();
  config.detector.nonlinearity_per_v = 0.1;
  Bench bent(config, "black-gloss"), good(ideal_config(), "black-gloss");
  for (const double tr : {30.0, 34.0, 60.0}) {
    const double s = signal(good, 30, tr);
    EXPECT_NEAR(signal(bent, 30, tr), s / (1.0 + 0.1 * s), 1e-12);
  }
}

TEST(Photodiode, FlattensAboveItsKnee) {
  PlantConfig config = ideal_config();
  config.detector.inverse_knee_per_v = 10.0;
  Bench bent(config, "black-gloss"), good(ideal_config(), "black-gloss");
  const double peak = signal(good, 60, 60);
  ASSERT_GT(peak, 0.3);
  EXPECT_NEAR(signal(bent, 60, 60), 0.1, 0.002);
  const double low = signal(good, 30, 60);
  EXPECT_NEAR(signal(bent, 30, 60) / low, 1.0, 1e-3);
}

TEST(Pickup, StaysWithTheShutterClosedAndHasBothComponents) {
  PlantConfig config = ideal_config();
  config.amplifier.pickup_v = 5e-4;
  config.amplifier.pickup_y_fraction = -0.5;
  Bench bench(config, "white-99");
  bench.plant().set_shutter(false, bench.time_s());
  bench.gain(2);
  const LockinResult r = bench.measure(200);
  EXPECT_NEAR(r.x_v, 5e-4, 6.0 * bench.standard_error(200));
  EXPECT_NEAR(r.y_v, -2.5e-4, 6.0 * bench.standard_error(200));
}

TEST(LockinPhase, TurnsXIntoY) {
  for (const double phase : {-12.0, -0.3, 5.0, 90.0}) {
    PlantConfig config = ideal_config();
    config.amplifier.phase_deg = phase;
    Bench bench(config, "white-99");
    bench.laser(red_laser);
    bench.polarization(open, open);
    bench.geometry(10, 30);
    bench.gain(1);
    const double x = signal(bench, 10, 30) / std::cos(optics::radians(phase));
    const double full = phase == 90.0 ? bench.plant().expected(bench.time_s()).y_v : x;
    const LockinResult r = bench.measure();
    EXPECT_NEAR(r.x_v, full * std::cos(optics::radians(phase)), 6.0 * bench.standard_error());
    EXPECT_NEAR(r.y_v, full * std::sin(optics::radians(phase)), 6.0 * bench.standard_error());
  }
}

TEST(GainRatio, StepsWhereTheRangeChanges) {
  PlantConfig config = ideal_config();
  config.amplifier.gain_error_10 = 0.01;
  config.amplifier.gain_error_100 = -0.02;
  Bench bench(config, "black-gloss");
  const double ranges[] = {1.0, 1.01, 0.98, 1.0};
  bench.laser(red_laser);
  bench.geometry(30, 50);
  bench.optical_density(0);
  Bench good(ideal_config(), "black-gloss");
  const double exact = signal(good, 30, 50, 0, {0, 0});
  for (int range = 0; range < 3; ++range) {
    bench.gain(range);
    EXPECT_NEAR(bench.measure(200).x_v, exact * ranges[range], 6.0 * bench.standard_error(200))
        << range;
  }
}

TEST(Pedestal, LiftsSmallSignalsAtTheAdcOnly) {
  PlantConfig config = ideal_config();
  config.amplifier.pedestal_adc_v = 1e-3;
  Bench bench(config, "black-gloss"), good(ideal_config(), "black-gloss");
  const double weak = signal(good, 30, -60);
  for (int range = 0; range < 3; ++range) {
    bench.gain(range);
    const double gain = std::pow(10.0, range);
    EXPECT_NEAR(signal(bench, 30, -60), std::hypot(weak * gain, 1e-3) / gain, 1e-12);
  }
}

TEST(LaserDrift, IsMissedByTheMonitorAndPowerDriftIsNot) {
  PlantConfig config = ideal_config();
  config.laser[red_laser].drift_per_hour = 0.02;
  Bench bench(config, "white-99");
  const auto at = [&](double time_s) {
    bench.laser(red_laser);
    bench.geometry(10, 30);
    return bench.plant().expected(time_s);
  };
  EXPECT_NEAR(at(3600.0).x_v / at(0.0).x_v, 1.02, 1e-12);
  EXPECT_NEAR(at(3600.0).monitor_v / at(0.0).monitor_v, 1.0, 1e-12);

  config = ideal_config();
  config.laser[red_laser].power_drift_per_hour = 0.02;
  config.laser[red_laser].power_warmup = 0.1;
  Bench seen(config, "white-99");
  seen.laser(red_laser);
  const auto early = seen.plant().expected(0.0), late = seen.plant().expected(7200.0);
  EXPECT_NEAR(late.x_v / early.x_v, late.monitor_v / early.monitor_v, 1e-12);
  EXPECT_NEAR(late.monitor_v / early.monitor_v, 1.04 / 0.9, 1e-4);
}

TEST(LaserWarmup, DecaysWithItsTimeConstant) {
  PlantConfig config = ideal_config();
  config.laser[red_laser].warmup = 0.05;
  config.laser[red_laser].warmup_tau_s = 300.0;
  Bench bench(config, "white-99");
  bench.laser(red_laser);
  const double final = bench.plant().expected(1e6).x_v;
  EXPECT_NEAR(1.0 - bench.plant().expected(0.0).x_v / final, 0.05, 1e-9);
  EXPECT_NEAR(1.0 - bench.plant().expected(300.0).x_v / final, 0.05 * std::exp(-1.0), 1e-9);
}

TEST(WavelengthError, FollowsTheSlopeOfTheSpectrum) {
  PlantConfig config = ideal_config();
  config.laser[0].wavelength_error_nm = 3.0;
  Bench off(config, "red-gloss"), good(ideal_config(), "red-gloss");
  const auto sample = make_sample("red-gloss");
  const View green{open, open, 0};
  const double expected = optics::element(brdf_at(*sample, 10, -50, 0, 535), 0, 0) /
                          optics::element(brdf_at(*sample, 10, -50, 0, 532), 0, 0);
  EXPECT_GT(std::abs(expected - 1.0), 0.005);
  EXPECT_NEAR(signal(off, 10, -50, 0, green) / signal(good, 10, -50, 0, green), expected, 2e-4);
}

TEST(LaserCrosstalk, MixesRedReflectanceIntoTheGreenChannel) {
  PlantConfig config = ideal_config();
  config.laser[0].crosstalk_from[1] = 0.02;
  Bench mixed(config, "red-gloss"), good(ideal_config(), "red-gloss");
  const View green{open, open, 0}, red{open, open, 1};
  EXPECT_NEAR(signal(mixed, 10, -50, 0, green),
              signal(good, 10, -50, 0, green) + 0.02 * signal(good, 10, -50, 0, red), 1e-12);
  EXPECT_NEAR(signal(mixed, 10, -50, 0, red), signal(good, 10, -50, 0, red), 1e-12);
}

TEST(LineWidth, ChangesNothingWhereTheSpectrumIsStraight) {
  PlantConfig config = ideal_config();
  config.laser[2].line_width_nm = 2.0;
  Bench wide(config, "white-70"), good(ideal_config(), "white-70");
  const View infrared{open, open, 2};
  const double expected = signal(good, 10, 30, 0, infrared);
  // dhr falls by .030 over 181 nm on one side of 814 nm and by .008 over 86 nm on the other: a
  // kink, whose mean over ±2 nm is half the difference of the slopes times 2 nm.
  const double kink = 0.5 * 2.0 * (0.030 / 181.0 - 0.008 / 86.0) / 0.62;
  EXPECT_NEAR(signal(wide, 10, 30, 0, infrared) / expected - 1.0, kink, 0.1 * kink + 1e-7);
}

TEST(Settling, DecaysAfterAChangeOfRange) {
  PlantConfig config = ideal_config();
  config.amplifier.settle_v = 0.5;
  config.amplifier.settle_tau_s = 0.01;
  Bench bench(config, "white-99");
  const auto mean_code = [&](double time_s) {
    std::vector<std::uint16_t> signal_codes(128), monitor(128);
    bench.plant().sample(time_s, sample_rate_hz, 0, signal_codes, monitor);
    double sum = 0;
    for (const auto c : signal_codes) sum += c / 128.0;
    return sum - 2048.0;
  };
  bench.plant().set_gain(1, 20.0);
  EXPECT_NEAR(mean_code(20.0), 0.5 * 4096 / 3.3, 1.0);
  EXPECT_NEAR(mean_code(20.02), 0.5 * 4096 / 3.3 * std::exp(-2.0), 1.0);
  EXPECT_NEAR(mean_code(21.0), 0.0, 1.0);
}

TEST(Shutter, TakesItsTimeToOpen) {
  PlantConfig config = ideal_config();
  config.shutter.travel_s = 0.004;
  Bench bench(config, "white-99");
  bench.laser(red_laser);
  bench.plant().set_shutter(false, 20.0);
  bench.plant().set_shutter(true, 30.0);
  const double full = bench.plant().expected(31.0).x_v;
  EXPECT_NEAR(bench.plant().expected(30.001).x_v, 0.25 * full, 1e-9);
  EXPECT_EQ(bench.plant().expected(30.0).x_v, 0.0);
}

}  // namespace
}  // namespace umov::plant::test
