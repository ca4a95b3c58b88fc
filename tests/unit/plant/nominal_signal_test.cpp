// The ideal instrument, in the time domain, against the closed form of its signal.
#include <gtest/gtest.h>

#include <cmath>
#include <tuple>

#include "bench.hpp"
#include "host/optics/fresnel.hpp"
#include "host/optics/refractive_index.hpp"

namespace umov::plant::test {
namespace {

optics::Stokes<double> polarizer_vector(double axis_deg) {
  return std::isnan(axis_deg) ? optics::unpolarized<double>()
                              : optics::polarizer_stokes<double>(axis_deg);
}

optics::Stokes<double> analyzer_vector(double axis_deg) {
  return std::isnan(axis_deg) ? optics::unpolarized<double>()
                              : optics::analyzer_stokes<double>(axis_deg);
}

/// BRDF contracted with both Stokes vectors at the angles where the stages' steps really stand.
double contracted(const Sample& sample, Bench& bench, double polarizer, double analyzer,
                  double nm) {
  const double ti = bench.plant().true_angle_deg(0);
  const double tr = bench.plant().true_angle_deg(1);
  const Mueller m = sample.brdf(
      optics::incident_beam(optics::radians(ti)),
      optics::exit_beam(optics::radians(tr), optics::radians(bench.plant().true_angle_deg(2))), nm);
  return optics::contract(analyzer_vector(analyzer), m, polarizer_vector(polarizer)) *
         std::cos(optics::radians(tr));
}

TEST(NominalSignal, HoldsInEveryPolarisationStateAndDirection) {
  const std::vector<double> axes = {0.0, 90.0, 45.0, -30.0, open};
  const std::vector<std::tuple<double, double, double>> directions = {
      {30, 30, 0}, {30, -40, 0}, {45, 20, 60}, {0, 0, 0}, {50, 35, -110}, {20, 0, 30}};
  for (const char* name : {"red-gloss", "white-99", "black-matte"}) {
    const auto sample = std::shared_ptr<const Sample>(make_sample(name));
    Bench bench(ideal_config(), sample);
    double chi2 = 0.0;
    int count = 0;
    for (int laser = 0; laser < laser_count; ++laser) {
      bench.laser(laser);
      const LaserConfig& l = bench.plant().config().laser[static_cast<std::size_t>(laser)];
      for (const auto& [ti, tr, phi] : directions) {
        bench.geometry(ti, tr, phi);
        for (const double polarizer : axes) {
          for (const double analyzer : axes) {
            bench.polarization(polarizer, analyzer);
            const double expected =
                l.gain_constant_v * 1e-4 *
                contracted(*sample, bench, polarizer, analyzer, l.wavelength_nm);
            bench.gain(expected * 1.6 < 0.02 ? 2 : 0);
            const LockinResult r = bench.measure(10);
            const double monitor = l.monitor_v * (std::isnan(polarizer) ? 1.0 : 0.5);
            EXPECT_NEAR(r.monitor_v, monitor, 6.0 * bench.monitor_error(10));
            EXPECT_EQ(r.clipped, 0);
            const double se = bench.standard_error(10);
            EXPECT_NEAR(r.x_v, expected * monitor, 6.0 * se)
                << name << " " << ti << " " << tr << " " << phi << " " << polarizer << " "
                << analyzer;
            EXPECT_NEAR(r.y_v, 0.0, 6.0 * se);
            chi2 += std::pow((r.x_v - expected * monitor) / se, 2.0) + std::pow(r.y_v / se, 2.0);
            count += 2;
          }
        }
      }
    }
    // Neither biased nor noisier than stated.
    EXPECT_NEAR(chi2 / count, 1.0, 6.0 * std::sqrt(2.0 / count)) << name;
  }
}

TEST(NominalSignal, OfAMirrorIsItsReflectanceTimesTheMonitor) {
  Bench bench(ideal_config(), "germanium");
  const optics::IndexTable index = optics::IndexTable::embedded("Ge_Jellison");
  bench.optical_density(3);
  bench.laser(1);
  const LaserConfig& l = bench.plant().config().laser[1];
  for (const double theta_deg : {20.0, 45.0, 70.0}) {
    bench.geometry(theta_deg, theta_deg);
    const double cosine = std::cos(optics::radians(bench.plant().true_angle_deg(0)));
    const double n = index.n(0.633), kappa = index.kappa(0.633);
    bench.polarization(90.0, open);
    LockinResult r = bench.measure();
    EXPECT_NEAR(r.x_v,
                l.gain_constant_v * 0.5e-3 * l.monitor_v * optics::reflectance_s(n, kappa, cosine),
                6.0 * bench.standard_error());
    bench.polarization(0.0, 0.0);
    r = bench.measure();
    EXPECT_NEAR(r.x_v,
                l.gain_constant_v * 0.5e-3 * l.monitor_v * optics::reflectance_p(n, kappa, cosine),
                6.0 * bench.standard_error());
    // Beside the mirror direction there is nothing.
    bench.geometry(theta_deg, theta_deg - 1.0);
    EXPECT_NEAR(bench.measure().x_v, 0.0, 6.0 * bench.standard_error());
  }
}

TEST(NominalSignal, AnalyserRidesOnTheArmAtTheNormal) {
  // At θr = 0 the arm's s axis is (-sin φ, cos φ, 0): turning the detector's plane turns the
  // analyser, and mirror-reflected p light, which swings along x, meets it as Malus says.
  Bench bench(ideal_config(), "germanium");
  bench.optical_density(3);
  bench.laser(1);
  bench.polarization(0.0, 0.0);
  bench.geometry(0.0, 0.0, 0.0);
  const double full = bench.measure().x_v;
  for (const double phi : {20.0, 45.0, 90.0, -60.0}) {
    bench.geometry(0.0, 0.0, phi);
    const double part = std::pow(std::cos(optics::radians(phi)), 2.0);
    EXPECT_NEAR(bench.measure().x_v, full * part, 8.0 * bench.standard_error());
  }
}

TEST(NominalSignal, FitsTheAdcForAllShippedPaintsUpToSixtyDegrees) {
  for (const std::string name :
       {"black-matte", "black-semi-gloss", "black-gloss", "red-gloss", "white-99"}) {
    for (const auto& config : {ideal_config(), realistic_config()}) {
      Bench bench(config, name);
      bench.polarization(open, open);
      for (int laser = 0; laser < laser_count; ++laser) {
        bench.laser(laser);
        for (const double theta : {10.0, 45.0, 60.0}) {
          bench.geometry(theta, theta);
          // A fundamental of 2.1 V swings the ADC from end to end.
          EXPECT_LT(bench.plant().expected(bench.time_s()).x_v, 1.5) << name;
        }
      }
    }
  }
}

TEST(NominalSignal, ShowsNothingWithoutLightAndKeepsTheMonitorBehindAClosedShutter) {
  Bench bench(ideal_config(), "white-99");
  bench.geometry(10, 30);
  bench.gain(2);
  EXPECT_NEAR(bench.measure().x_v, 0.0, 6.0 * bench.standard_error());
  bench.laser(1);
  EXPECT_GT(bench.measure().x_v, 0.008);
  bench.plant().set_shutter(false, bench.time_s());
  LockinResult r = bench.measure();
  EXPECT_NEAR(r.x_v, 0.0, 6.0 * bench.standard_error());
  EXPECT_NEAR(r.monitor_v, 0.75, 6.0 * bench.monitor_error());
  bench.plant().set_shutter(true, bench.time_s());
  bench.plant().set_interlock(false);
  EXPECT_FALSE(bench.plant().interlock_closed());
  r = bench.measure();
  EXPECT_NEAR(r.x_v, 0.0, 6.0 * bench.standard_error());
  EXPECT_NEAR(r.monitor_v, 0.0, 6.0 * bench.monitor_error());
}

TEST(NominalSignal, FallsByTenWithEachStepOfDensityAndTheMonitorWithIt) {
  Bench bench(ideal_config(), "white-99");
  bench.geometry(10, 30);
  bench.laser(0);
  for (int density = 0; density <= 5; ++density) {
    bench.optical_density(density);
    const ExpectedSignal e = bench.plant().expected(bench.time_s());
    EXPECT_NEAR(e.monitor_v, 0.8 * std::pow(10.0, -density), 1e-12);
    EXPECT_NEAR(e.x_v / e.monitor_v / 760.0 / 1e-4,
                std::cos(optics::radians(30.0)) *
                    optics::contract(optics::analyzer_stokes<double>(0),
                                     brdf_at(bench.plant().sample_on_stage(), 10, 30, 0, 532),
                                     optics::polarizer_stokes<double>(0)),
                2e-5);
  }
  bench.turn(5, 90.0);  // between two holders
  EXPECT_EQ(bench.plant().expected(bench.time_s()).x_v, 0.0);
}

TEST(NominalSignal, IsTheSameForAReferenceThatDoesNotDivideTheSampleRate) {
  Bench bench(ideal_config(), "white-99");
  bench.geometry(10, 30);
  bench.laser(1);
  // 1237.5 Hz at 100 kS/s: 99 periods in 8000 samples, so that the wave is met at phases k/8000.
  const std::uint32_t step = Bench::reference(1237.5);
  bench.plant().set_reference(step);
  std::vector<std::uint16_t> signal(200'000), monitor(200'000);
  bench.plant().sample(20.0, sample_rate_hz, 0, signal, monitor);
  double x = 0.0, y = 0.0;
  for (std::size_t n = 0; n < signal.size(); ++n) {
    const double turns = std::fmod(static_cast<double>(n) * 99.0 / 8000.0, 1.0) + 0.5 / 8000.0;
    x += (monitor[n] - 2048.0) * std::sin(2.0 * optics::pi * turns);
    y += (monitor[n] - 2048.0) * std::cos(2.0 * optics::pi * turns);
  }
  const double scale = 2.0 / static_cast<double>(signal.size()) * 3.3 / 4096.0;
  EXPECT_NEAR(x * scale, 0.75, 1.5e-5);
  EXPECT_NEAR(y * scale, 0.0, 1.5e-5);
}

}  // namespace
}  // namespace umov::plant::test
