// Troubles of the instrument that no catalogue of effects needs to know, and the sizes of speckle.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "expected_signal.hpp"
#include "hil/plant/parameter_list.hpp"

namespace umov::plant::test {
namespace {

PlantConfig with(const std::vector<std::string>& settings) {
  return make_config("ideal", settings);
}

TEST(FilterGhost, AddsTheSignalOfAnotherDirection) {
  Bench ghost(with({"ghost.share=0.01", "ghost.angle_deg=9"}), "black-gloss");
  Bench good(ideal_config(), "black-gloss");
  EXPECT_NEAR(signal(ghost, 30, 18.0) - signal(good, 30, 18.0), 0.01 * signal(good, 30, 27.0),
              1e-9);
}

TEST(Windup, GrowsAfterAReversalAndSaturates) {
  PlantConfig config = ideal_config();
  config.axis[3].windup_deg = 1.0;
  config.axis[3].windup_travel_deg = 10.0;
  Bench bench(config, "white-99");
  bench.turn(3, 90.0);
  EXPECT_NEAR(bench.plant().true_angle_deg(3), 89.0, 1e-3);
  bench.turn(3, 80.0);
  EXPECT_NEAR(bench.plant().true_angle_deg(3), 80.0 + 1.0 - 2.0 * std::exp(-1.0), 1e-3);
}

TEST(Windup, DoesNotDependOnHowTheMoveIsCut) {
  PlantConfig config = ideal_config();
  config.axis[1].windup_deg = 0.5;
  config.axis[1].backlash_deg = 0.1;
  Bench steps(config, "white-99"), leap(config, "white-99");
  for (const double to : {20.0, -13.0, 4.0}) {
    steps.turn(1, to);
    leap.plant().turn_to(1, std::llround(to * 1000.0), 0.0);
    EXPECT_NEAR(steps.plant().true_angle_deg(1), leap.plant().true_angle_deg(1), 1e-9);
  }
}

TEST(Slip, HappensOnceInTheFirstMoveAfterItsTime) {
  PlantConfig config = ideal_config();
  config.axis[1].slip_deg = 0.3;
  config.axis[1].slip_time_s = 100.0;
  Bench bench(config, "white-99");
  bench.turn(1, 20.0);
  EXPECT_NEAR(bench.plant().true_angle_deg(1), 20.0, 1e-9);
  bench.wait(200.0);
  EXPECT_NEAR(bench.plant().true_angle_deg(1), 20.0, 1e-9);
  bench.turn(1, 10.0);
  EXPECT_NEAR(bench.plant().true_angle_deg(1), 10.3, 1e-9);
  bench.turn(1, -10.0);
  EXPECT_NEAR(bench.plant().true_angle_deg(1), -9.7, 1e-9);
}

TEST(PlateBend, GrowsWithTheIncidenceAndStaysWhenTheSampleIsTurned) {
  Bench bent(with({"mount.sag_deg=0.9"}), "black-gloss"), good(ideal_config(), "black-gloss");
  // sin 30° of .9° leans the plate by .45°.
  EXPECT_NEAR(signal(bent, 30.0, 28.8), signal(good, 30.45, 28.35),
              1e-5 * signal(good, 30.45, 28.35));
  EXPECT_EQ(signal(bent, 0.0, 10.0), signal(good, 0.0, 10.0));
  bent.plant().arrange({.sample_azimuth_deg = 180.0});
  EXPECT_NEAR(signal(bent, 30.0, 28.8), signal(good, 30.45, 28.35),
              1e-5 * signal(good, 30.45, 28.35));
}

TEST(PolarizerWedge, SteersTheBeamAsItTurns) {
  Bench wedged(with({"polarizer.wedge_deg=0.45"}), "black-gloss");
  Bench good(ideal_config(), "black-gloss");
  // At p the beam is bent within the plane of incidence.
  EXPECT_NEAR(signal(wedged, 30, 28.8, 0, {0, open}), signal(good, 30.45, 28.8, 0, {0, open}),
              1e-6 * signal(good, 30, 28.8));
  // At s out of it; with the polariser out not at all.
  EXPECT_NEAR(signal(wedged, 30, 28.8, 0, {90, open}) / signal(good, 30, 28.8, 0, {90, open}), 1.0,
              0.01);
  EXPECT_EQ(signal(wedged, 30, 28.8), signal(good, 30, 28.8));
}

TEST(WindowStrain, TurnsThePolarisationBeforeTheAnalyser) {
  Bench strained(with({"collection.window_retardance_deg=180", "collection.window_axis_deg=45"}),
                 "germanium");
  Bench good(ideal_config(), "germanium");
  strained.optical_density(3);
  good.optical_density(3);
  // Half a wave at 45° swaps s and p.
  EXPECT_NEAR(signal(strained, 40, 40, 0, {0, 90}), signal(good, 40, 40, 0, {0, 0}), 1e-9);
  EXPECT_NEAR(signal(strained, 40, 40, 0, {0, 0}), 0.0, 1e-9);
}

TEST(WrongFilter, FavoursOnePolarisationAtOneWavelength) {
  Bench wrong(with({"laser.633.filter_diattenuation=0.1", "laser.633.filter_axis_deg=90"}),
              "lambertian-99");
  Bench good(ideal_config(), "lambertian-99");
  const auto ratio = [&](double analyzer, int laser) {
    return signal(wrong, 10, 20, 0, {0, analyzer, laser}) /
           signal(good, 10, 20, 0, {0, analyzer, laser});
  };
  EXPECT_NEAR(ratio(90, 1), 1.1, 1e-9);
  EXPECT_NEAR(ratio(0, 1), 0.9, 1e-9);
  EXPECT_NEAR(ratio(open, 1), 1.0, 1e-9);
  EXPECT_EQ(ratio(90, 0), 1.0);
  EXPECT_EQ(ratio(90, 2), 1.0);
}

TEST(MotorPickup, FollowsTheWeightOfTheArmWithoutLight) {
  Bench bench(with({"amplifier.motor_pickup_v=1e-4"}), "black-matte");
  bench.laser(-1);
  bench.turn(1, 30.0);
  EXPECT_NEAR(bench.plant().expected(0.0).x_v, 0.5e-4, 1e-9);
  bench.turn(1, -90.0);
  EXPECT_NEAR(bench.plant().expected(0.0).x_v, -1e-4, 1e-9);
  EXPECT_EQ(bench.plant().expected(0.0).y_v, 0.0);
  const LockinResult r = bench.measure(200);
  EXPECT_NEAR(r.x_v, -1e-4, 6.0 * bench.standard_error(200));
}

TEST(Daylight, CompressesTheSignalWhileItShines) {
  Bench bench(
      with({"daylight.level_v=0.5", "daylight.compression_per_v=0.1", "daylight.period_s=400"}),
      "white-99");
  Bench good(ideal_config(), "white-99");
  signal(bench, 30, 10);
  const double plain = signal(good, 30, 10);
  // A quarter of the period in, the sun is out; three quarters in, it is not.
  const double lit = bench.plant().expected(100.0).x_v;
  const double dim = bench.plant().expected(300.0).x_v;
  const double level = 0.5;
  EXPECT_NEAR(lit, (level + plain) / (1 + 0.1 * (level + plain)) - level / (1 + 0.1 * level),
              1e-12);
  EXPECT_EQ(dim, plain);
}

TEST(HumidGloss, WidensTheLobeAndComesBack) {
  Bench bench(with({"humidity.slope_change=0.2", "humidity.period_s=1000"}), "black-gloss");
  Bench good(ideal_config(), "black-gloss");
  const double plain = signal(good, 30, 30);
  signal(bench, 30, 30);
  EXPECT_NEAR(bench.plant().expected(0.0).x_v, plain, 1e-12);
  EXPECT_LT(bench.plant().expected(500.0).x_v, 0.8 * plain);
  EXPECT_NEAR(bench.plant().expected(1000.0).x_v, plain, 1e-9 * plain);
}

TEST(ModulationWander, MovesSignalAndMonitorTogether) {
  Bench bench(with({"modulation.wander_deg=2", "modulation.wander_period_s=400"}), "white-99");
  signal(bench, 30, 10);
  const ExpectedSignal quarter = bench.plant().expected(100.0);
  const ExpectedSignal start = bench.plant().expected(0.0);
  EXPECT_NEAR(quarter.y_v / quarter.x_v, std::tan(optics::radians(2.0)), 1e-9);
  EXPECT_EQ(start.y_v, 0.0);
  EXPECT_NEAR(quarter.x_v / quarter.monitor_v, start.x_v / start.monitor_v, 1e-12);
}

TEST(ModulationJitter, ScattersYAndHardlyX) {
  Bench bench(with({"modulation.jitter_deg=3", "amplifier.output_noise_v=0.0005"}), "white-99");
  bench.geometry(30, 10);
  bench.laser(red_laser);
  double y2 = 0.0;
  double x2 = 0.0;
  double x1 = 0.0;
  constexpr int records = 40;
  for (int i = 0; i < records; ++i) {
    const LockinResult r = bench.measure(20);
    y2 += r.y_v * r.y_v / records;
    x2 += r.x_v * r.x_v / records;
    x1 += r.x_v / records;
  }
  const double x_scatter = std::sqrt(x2 - x1 * x1);
  // 3° an interval of 128 samples, 2000 samples: about 3°/√16 a record.
  EXPECT_NEAR(std::sqrt(y2) / x1, optics::radians(3.0) / std::sqrt(2000.0 / 128.0), 0.004);
  EXPECT_LT(x_scatter, 0.3 * std::sqrt(y2));
}

TEST(Jitter, ScattersTheSignalAndNotTheMonitor) {
  Bench bench(with({"laser.633.jitter=0.04"}), "white-99");
  bench.geometry(30, 10);
  bench.laser(red_laser);
  double x1 = 0.0, x2 = 0.0, m1 = 0.0, m2 = 0.0;
  constexpr int records = 60;
  for (int i = 0; i < records; ++i) {
    const LockinResult r = bench.measure(20);
    x1 += r.x_v / records;
    x2 += r.x_v * r.x_v / records;
    m1 += r.monitor_v / records;
    m2 += r.monitor_v * r.monitor_v / records;
  }
  EXPECT_NEAR(std::sqrt(x2 - x1 * x1) / x1, 0.04 / std::sqrt(2000.0 / 128.0), 0.0035);
  EXPECT_LT(std::sqrt(std::max(0.0, m2 - m1 * m1)) / m1, 1e-4);
}

TEST(ShutterLeak, PassesItsShareWhenClosed) {
  Bench bench(with({"shutter.leak=0.001"}), "white-99");
  const double lit = signal(bench, 30, 10);
  bench.plant().set_shutter(false, bench.time_s());
  EXPECT_NEAR(bench.plant().expected(bench.time_s()).x_v, 0.001 * lit, 1e-9);
}

TEST(Speckle, ComesBackWithTheGeometryAndChangesWithThePlace) {
  Bench bench(with({"speckle.contrast=0.1"}), "white-99");
  Bench good(ideal_config(), "white-99");
  const double first = signal(bench, 30, 10) / signal(good, 30, 10);
  const double elsewhere = signal(bench, 30, 11) / signal(good, 30, 11);
  EXPECT_NE(first, elsewhere);
  EXPECT_EQ(signal(bench, 30, 10) / signal(good, 30, 10), first);
  bench.plant().arrange({.sample_shift_mm = 1.0});
  EXPECT_NE(signal(bench, 30, 10) / signal(good, 30, 10), first);
  bench.plant().arrange({});
  EXPECT_EQ(signal(bench, 30, 10) / signal(good, 30, 10), first);
}

TEST(Session, HasItsOwnNoiseOnTheSameBenchWithTheSameSpeckle) {
  const auto codes = [](std::uint64_t session) {
    PlantSetup setup;
    setup.config = with({"speckle.contrast=0.1", "amplifier.input_noise_v=1e-3"});
    setup.sample = make_sample("white-99");
    setup.session = session;
    Plant plant(std::move(setup));
    std::vector<std::uint16_t> signal(512), monitor(512);
    plant.set_laser(0, true, 0.0);
    plant.set_shutter(true, 0.0);
    plant.sample(1.0, 100000.0, 0, signal, monitor);
    return std::pair(signal, plant.expected(1.0).x_v);
  };
  const auto first = codes(0), again = codes(0), later = codes(1);
  EXPECT_EQ(first.first, again.first);
  EXPECT_NE(first.first, later.first);
  EXPECT_EQ(first.second, later.second);
}

TEST(Speckle, HasItsContrastAndMeanOneOverManyGeometries) {
  Bench bench(with({"speckle.contrast=0.2"}), "lambertian-99");
  Bench good(ideal_config(), "lambertian-99");
  double sum = 0.0;
  double sum2 = 0.0;
  int count = 0;
  for (double tr = -60.0; tr <= 60.0; tr += 0.25) {
    for (int laser = 0; laser < 3; ++laser) {
      const double s = signal(bench, 5, tr, 0, {open, open, laser}) /
                       signal(good, 5, tr, 0, {open, open, laser});
      sum += s;
      sum2 += s * s;
      ++count;
    }
  }
  const double mean = sum / count;
  EXPECT_NEAR(mean, 1.0, 4.0 * 0.2 / std::sqrt(count));
  EXPECT_NEAR(std::sqrt(sum2 / count - mean * mean), 0.2, 4.0 * 0.2 / std::sqrt(2.0 * count));
}

TEST(EveryImperfection, AtSizeZeroLeavesTheSignalAsItIsToTheLastBit) {
  // Shapes of imperfections whose size is zero must not matter.
  PlantConfig config = ideal_config();
  for (AxisErrors& axis : config.axis) axis.windup_travel_deg = 7.0;
  config.ghost.angle_deg = 11.0;
  config.modulation.wander_period_s = 77.0;
  config.daylight.level_v = 1.0;  // no compression
  config.humidity.period_s = 99.0;
  config.dust.g = 0.1;
  config.film.slope_rms = 0.2;
  config.drops.contact_angle_deg = 60.0;
  config.marks.lobe_slope = 0.3;
  config.marks.retro_width_deg = 4.0;
  config.marks.fringe_thickness_um = 3.0;
  config.marks.beam_offset_mm = 4.0;
  config.collection.window_axis_deg = 10.0;
  for (LaserConfig& l : config.laser) l.filter_axis_deg = 12.0;
  Bench changed(config, "red-gloss"), good(ideal_config(), "red-gloss");
  for (const double tr : {-40.0, 20.0, 50.0}) {
    for (const double analyzer : {0.0, 90.0, open}) {
      EXPECT_EQ(signal(changed, 50, tr, 0, {45, analyzer}),
                signal(good, 50, tr, 0, {45, analyzer}));
      const LockinResult a = changed.measure(5);
      const LockinResult b = good.measure(5);
      EXPECT_EQ(a.x_v, b.x_v);
      EXPECT_EQ(a.y_v, b.y_v);
      EXPECT_EQ(a.monitor_v, b.monitor_v);
    }
  }
}

}  // namespace
}  // namespace umov::plant::test
