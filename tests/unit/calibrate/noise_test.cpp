#include "host/calibrate/noise.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "host/errors/error.hpp"
#include "tests/unit/calibrate/synthetic_scan.hpp"

namespace umov::calibrate {
namespace {

using namespace test;

double true_variance(const Instrument& i, double s, double gain) {
  return i.base_v * i.base_v + i.adc_v * i.adc_v / (gain * gain) + i.shot_v * s +
         i.relative * i.relative * s * s;
}

TEST(Noise, TheLawFollowsTheTrueVarianceOverSignalAndRange) {
  Instrument instrument;
  Plan plan;
  plan.step = 1;
  plan.theta_i = {0, 20, 40, 60};
  const auto lobe =
      depolarising([](double t, double) { return 0.02 + 3 * std::exp(-t * t / 200); });
  double worst = 0, square = 0;
  int count = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const NoiseModel model = fit_noise(make_scan(instrument, lobe, plan, seed));
    for (const auto& [s, gain] :
         {std::pair{0.0013, 1000.0}, {0.004, 100.0}, {0.014, 100.0}, {0.05, 10.0}, {0.14, 10.0}}) {
      const double error =
          model.variance_x(532, gain, s) / true_variance(instrument, s, gain) - 1.0;
      worst = std::max(worst, std::abs(error));
      square += error * error;
      ++count;
    }
  }
  // 676 records of 9 degrees of freedom: some 2 to 6 % in the variance where records lie.
  EXPECT_LT(std::sqrt(square / count), 0.08);
  EXPECT_LT(worst, 0.35);
}

TEST(Noise, DegreesOfFreedomOfTheBlockScatterAreFound) {
  Instrument instrument;
  Plan plan;
  plan.step = 0.25;
  double sum = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed)
    sum += fit_noise(make_scan(instrument, lambertian(0.9), plan, seed)).at(532).x.dof / 10;
  EXPECT_NEAR(sum, 9.0, 1.0);
}

TEST(Noise, SpikesInAFewRecordsDoNotRaiseTheLaw) {
  Instrument instrument;
  Plan plan;
  plan.step = 0.5;
  auto scan = make_scan(instrument, lambertian(0.9), plan, 3);
  const NoiseModel clean = fit_noise(scan);
  for (std::size_t i = 0; i < scan.size(); i += 25) scan.x_se_v[i] *= 30;
  const NoiseModel spiked = fit_noise(scan);
  EXPECT_NEAR(spiked.variance_x(532, 100, 0.01) / clean.variance_x(532, 100, 0.01), 1.0, 0.1);
  EXPECT_GE(spiked.at(532).x.outliers, scan.size() / 25);
}

TEST(Noise, ThreeRecordsStillGiveALaw) {
  Instrument instrument;
  Plan plan;
  plan.from = 20;
  plan.to = 40;
  plan.step = 10;
  double log_ratio = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const auto scan = make_scan(instrument, lambertian(0.9), plan, seed);
    ASSERT_EQ(scan.size(), 3U);
    const double s = scan.x_v[1], gain = scan.gain[1];
    const double ratio =
        fit_noise(scan).variance_x(532, gain, s) / true_variance(instrument, s, gain);
    EXPECT_GT(ratio, 0.05);
    EXPECT_LT(ratio, 8.0);
    log_ratio += std::log(ratio) / 40;
  }
  EXPECT_NEAR(log_ratio, 0.0, 0.3);
}

TEST(Noise, SaturatedRecordsTakeNoPartAndNothingElseIsRefused) {
  Instrument instrument;
  Plan plan;
  auto scan = make_scan(instrument, lambertian(0.9), plan, 3);
  const double before = fit_noise(scan).variance_x(532, 100, 0.01);
  add_closed(scan, instrument, {100}, 1, 9);  // one more row, then spoilt
  scan.saturated.back() = 1;
  scan.x_se_v.back() = 1.0;
  EXPECT_DOUBLE_EQ(fit_noise(scan).variance_x(532, 100, 0.01), before);
  scan.saturated.assign(scan.size(), 1);
  EXPECT_THROW(fit_noise(scan), Error);
  EXPECT_THROW(fit_noise(make_scan(instrument, lambertian(0.9), plan, 3)).at(814), Error);
}

TEST(Noise, ScanWithoutAnyScatterHasFinitePositiveVariance) {
  Instrument instrument;
  instrument.base_v = instrument.adc_v = instrument.shot_v = instrument.relative = 0;
  const NoiseModel model = fit_noise(make_scan(instrument, lambertian(0.9), Plan{}, 1));
  EXPECT_GT(model.variance_x(532, 100, 0.01), 0);
  EXPECT_LT(model.variance_x(532, 100, 0.01), 1e-15);
}

TEST(Noise, VoltagesOnTheConvertersLatticeCarryItsRounding) {
  Instrument instrument;
  Plan plan;
  plan.gain = 100;
  auto scan = make_scan(instrument, lambertian(0.9), plan, 5);
  const double step = 1e-3;
  scan.set_key("adc_step_v", "0.001");
  EXPECT_EQ(fit_noise(scan).quantisation_v, 0.0) << "outputs finer than a code are averages";
  for (auto* column : {&scan.x_v, &scan.y_v})
    for (double& v : *column) v = std::round(v * 100 / step) * step / 100;
  const NoiseModel model = fit_noise(scan);
  EXPECT_EQ(model.quantisation_v, step);
  EXPECT_NEAR(model.variance_x(532, 100, 0.01) - model.at(532).x.variance(0.01, 100),
              step * step / 1e4 / 12, 1e-17);
}

TEST(Noise, RepeatsShowSlowScatterThatBlocksDoNotSee) {
  Instrument instrument;
  instrument.slow_relative = 0.004;
  Plan plan;
  plan.repeats = 4;
  const NoiseModel model = fit_noise(make_scan(instrument, lambertian(0.9), plan, 2));
  EXPECT_NEAR(std::sqrt(model.at(532).x.relative2), 5e-4, 2.5e-4);
  const double s = 0.018;
  EXPECT_NEAR(std::sqrt(model.variance_normalised(532, 10, s)) / s, 0.004, 0.0006);
}

TEST(Noise, RepeatsOfSignalsFarAboveTheFloorKeepTheirRelativeNoise) {
  Instrument instrument;
  instrument.base_v = instrument.adc_v = instrument.shot_v = 0;
  instrument.relative = 0.0035;
  Plan plan;
  plan.repeats = 2;
  const NoiseModel model = fit_noise(make_scan(instrument, lambertian(0.9), plan, 2));
  EXPECT_NEAR(std::sqrt(model.variance_normalised(532, 10, 0.018)) / 0.018, 0.0035, 0.001);
}

TEST(Noise, SourceFluctuationThatTheMonitorCancelsIsNotCountedWhereRepeatsTellSo) {
  Instrument instrument;
  instrument.source_relative = 0.01;
  Plan plan;
  plan.repeats = 4;
  const NoiseModel model = fit_noise(make_scan(instrument, lambertian(0.9), plan, 2));
  EXPECT_NEAR(model.at(532).monitor_relative, 0.01, 0.002);
  const double s = 0.018;
  EXPECT_LT(std::sqrt(model.variance_normalised(532, 10, s)) / s, 0.0015);
}

TEST(Noise, TheMonitorsOwnNoiseIsCountedWithoutRepeats) {
  Instrument instrument;
  instrument.monitor_relative = 0.003;
  Plan plan;
  plan.step = 1;
  const NoiseModel model = fit_noise(make_scan(instrument, lambertian(0.9), plan, 2));
  EXPECT_NEAR(std::sqrt(model.variance_normalised(532, 10, 0.018)) / 0.018, 0.003, 0.0008);
}

}  // namespace
}  // namespace umov::calibrate
