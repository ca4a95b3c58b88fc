// Imperfections of stages, beam and collection, each alone, by the first-order signature it must
// have.
#include <gtest/gtest.h>

#include <cmath>

#include "expected_signal.hpp"

namespace umov::plant::test {
namespace {

TEST(DetectorZero, MovesTheLobeByItsAngle) {
  PlantConfig config = ideal_config();
  config.axis[1].zero_deg = 0.9;  // a whole number of steps
  Bench off(config, "black-gloss"), good(ideal_config(), "black-gloss");
  for (const double tr : {25.2, 28.8, 32.4}) {
    EXPECT_NEAR(signal(off, 30.0, tr), signal(good, 30.0, tr + 0.9), 1e-9);
  }
}

TEST(SampleTilt, ActsAsAZeroErrorOfBothArmsAndTurnsWithTheSample) {
  PlantConfig config = ideal_config();
  config.mount.tilt_in_plane_deg = 0.45;
  Bench tilted(config, "black-gloss"), good(ideal_config(), "black-gloss");
  EXPECT_NEAR(signal(tilted, 30.6, 28.8), signal(good, 31.05, 28.35),
              1e-5 * signal(good, 31.05, 28.35));
  tilted.plant().arrange({.sample_azimuth_deg = 180.0});
  EXPECT_NEAR(signal(tilted, 30.6, 28.8), signal(good, 30.15, 29.25),
              1e-5 * signal(good, 30.15, 29.25));
}

TEST(SampleTilt, OutOfPlaneCostsTheSquareOfItselfAtThePeak) {
  const auto loss = [](double tilt) {
    PlantConfig config = ideal_config();
    config.mount.tilt_out_of_plane_deg = tilt;
    Bench tilted(config, "black-gloss"), good(ideal_config(), "black-gloss");
    return 1.0 - signal(tilted, 30, 30) / signal(good, 30, 30);
  };
  EXPECT_GT(loss(0.2), 1e-4);
  EXPECT_NEAR(loss(0.4) / loss(0.2), 4.0, 0.1);
  EXPECT_NEAR(loss(-0.2) / loss(0.2), 1.0, 1e-6);
}

TEST(Eccentricity, IsASineOfTheArmsAngle) {
  PlantConfig config = ideal_config();
  config.axis[1].eccentricity_deg = 0.3;
  config.axis[1].eccentricity_phase_deg = 20.0;
  Bench bench(config, "white-99");
  for (const double tr : {-70.2, -9.9, 0.0, 45.0}) {
    bench.turn(1, tr);
    EXPECT_NEAR(bench.plant().true_angle_deg(1), tr + 0.3 * std::sin(optics::radians(tr + 20.0)),
                1e-3);
  }
}

TEST(Backlash, FlipsWithTheDirectionOfTravel) {
  PlantConfig config = ideal_config();
  config.axis[1].backlash_deg = 0.2;
  Bench bench(config, "white-99");
  bench.arrive(1, 18.0, +1);
  EXPECT_NEAR(bench.plant().true_angle_deg(1), 17.9, 1e-9);
  bench.arrive(1, 18.0, -1);
  EXPECT_NEAR(bench.plant().true_angle_deg(1), 18.1, 1e-9);
  // Within the play the stage stands still.
  bench.turn(1, 18.09);
  EXPECT_NEAR(bench.plant().true_angle_deg(1), 18.1, 1e-9);
}

TEST(PolarizerLeakage, BringsItsRatioOfTheParallelLightIntoTheCrossedChannel) {
  // A mirror at normal incidence keeps polarisation: crossed light is leakage alone.
  for (const bool analyzer : {false, true}) {
    PlantConfig config = ideal_config();
    (analyzer ? config.analyzer : config.polarizer).extinction = 1e-4;
    Bench bench(config, "germanium");
    bench.optical_density(3);
    const double crossed = signal(bench, 0, 0, 0, {0.0, 90.0});
    const double parallel = signal(bench, 0, 0, 0, {0.0, 0.0});
    EXPECT_NEAR(crossed / parallel, 1e-4, 1e-7);
  }
}

TEST(PolarizerRotation, LeaksTheSquareOfItsSine) {
  PlantConfig config = ideal_config();
  config.axis[3].zero_deg = 2.0;
  Bench bench(config, "germanium");
  bench.optical_density(3);
  const double ratio = signal(bench, 0, 0, 0, {0.0, 90.0}) / signal(bench, 0, 0, 0, {0.0, 0.0});
  EXPECT_NEAR(ratio, std::pow(std::tan(optics::radians(2.0)), 2.0), 1e-6);
}

TEST(PolarizerRotation, TurnsFromPTowardsS) {
  // At 45° commanded and near Brewster's angle more s light means more signal.
  PlantConfig config = ideal_config();
  config.axis[3].zero_deg = 1.0;
  Bench turned(config, "black-gloss"), good(ideal_config(), "black-gloss");
  EXPECT_GT(signal(turned, 55, 55, 0, {45.0, open}), signal(good, 55, 55, 0, {45.0, open}));
}

TEST(DetectorPolarizationBias, FavoursTheSAnalyserAtAllAngles) {
  PlantConfig config = ideal_config();
  config.detector.polarization_bias = 0.02;
  Bench biased(config, "lambertian-99"), good(ideal_config(), "lambertian-99");
  for (const double tr : {-30.0, 10.0, 60.0}) {
    EXPECT_NEAR(signal(biased, 10, tr, 0, {0, 90}) / signal(good, 10, tr, 0, {0, 90}), 1.02, 1e-9);
    EXPECT_NEAR(signal(biased, 10, tr, 0, {0, 0}) / signal(good, 10, tr, 0, {0, 0}), 0.98, 1e-9);
    EXPECT_NEAR(signal(biased, 10, tr, 0, {0, open}) / signal(good, 10, tr, 0, {0, open}), 1.0,
                1e-9);
  }
}

TEST(SourcePolarization, ShowsOnlyWithThePolariserOut) {
  PlantConfig config = ideal_config();
  for (LaserConfig& l : config.laser) {
    l.polarization = 0.2;
    l.polarization_deg = 90.0;
  }
  Bench bench(config, "black-gloss"), good(ideal_config(), "black-gloss");
  const auto ratio = [](Bench& b, double polarizer) {
    const double x = signal(b, 50, 50, 0, {polarizer, open});
    return x / b.plant().expected(b.time_s()).monitor_v;
  };
  EXPECT_NEAR(ratio(bench, 0.0), ratio(good, 0.0), 1e-12);
  EXPECT_NEAR(ratio(bench, open), 0.6 * ratio(good, 90.0) + 0.4 * ratio(good, 0.0), 1e-6);
}

TEST(FiniteAperture, SmearsByTheSecondDerivative) {
  const double half_deg = 0.4;
  PlantConfig config = ideal_config();
  config.collection.half_angle_deg = half_deg;
  Bench wide(config, "black-gloss"), point(ideal_config(), "black-gloss");
  const double ti = 30.6, tr = 30.6, h = 0.45;
  const double in_plane =
      (signal(point, ti, tr + h) - 2.0 * signal(point, ti, tr) + signal(point, ti, tr - h)) /
      (h * h);
  // Across the plane, an azimuth step dφ is an angle sin θr · dφ (up to second order in the lobe).
  const double d_phi = h / std::sin(optics::radians(tr));
  const double across = 2.0 * (signal(point, ti, tr, d_phi) - signal(point, ti, tr)) / (h * h);
  // The mean of x² over a disc of radius a is a²/4 per axis. On the sphere the azimuth circle also
  // bends: at the lobe's top the first derivative that this multiplies is small.
  const double expected = 0.5 * half_deg * half_deg / 4.0 * (in_plane + across);
  const double change = signal(wide, ti, tr) - signal(point, ti, tr);
  EXPECT_LT(change, 0.0);
  EXPECT_NEAR(change / expected, 1.0, 0.1);
}

TEST(FiniteAperture, ConvergesToADenseAverageOverTheDisc) {
  PlantConfig config = ideal_config();
  config.collection.half_angle_deg = 0.6;
  Bench wide(config, "black-gloss");
  const double value = signal(wide, 30, 32);
  const auto sample = make_sample("black-gloss");
  const Beam in = optics::incident_beam(optics::radians(wide.plant().true_angle_deg(0)));
  const Beam out = optics::exit_beam(optics::radians(wide.plant().true_angle_deg(1)), 0.0);
  double sum = 0.0;
  constexpr int rings = 40, turns = 60;
  for (int i = 0; i < rings; ++i) {
    const double angle = optics::radians(0.6) * std::sqrt((i + 0.5) / rings);
    for (int j = 0; j < turns; ++j) {
      const double t = 2.0 * optics::pi * j / turns;
      const Vec3 k =
          std::cos(angle) * out.k + std::sin(angle) * (std::cos(t) * out.s + std::sin(t) * out.p);
      sum += optics::element(sample->brdf(in, optics::beam_along(k), 633), 0, 0) * k.z;
    }
  }
  EXPECT_NEAR(value, 820.0 * 1e-4 * 1.5 * sum / (rings * turns), 2e-5 * value);
}

TEST(BeamDivergence, SmearsTheLobe) {
  PlantConfig config = ideal_config();
  config.beam.divergence_rms_deg = 0.3;
  Bench wide(config, "black-gloss"), point(ideal_config(), "black-gloss");
  EXPECT_LT(signal(wide, 30, 30), signal(point, 30, 30));
  EXPECT_GT(signal(wide, 30, 40), signal(point, 30, 40));
}

TEST(BeamDivergence, SpillsAMirroredBeamOverTheAperturesEdge) {
  PlantConfig config = ideal_config();
  config.beam.divergence_rms_deg = 0.1;
  Bench wide(config, "germanium"), sharp(ideal_config(), "germanium");
  wide.optical_density(3);
  sharp.optical_density(3);
  const double radius = optics::degrees(std::acos(1.0 - 1e-4 / (2.0 * optics::pi)));
  const double share = signal(wide, 45, 45) / signal(sharp, 45, 45);
  EXPECT_NEAR(share, 1.0 - std::exp(-0.5 * std::pow(radius / 0.1, 2.0)), 2e-4);
}

TEST(RetroOcclusion, CutsAHoleAboutTheRetroDirection) {
  PlantConfig config = ideal_config();
  config.collection.retro_half_angle_deg = 3.0;
  Bench blocked(config, "white-99"), good(ideal_config(), "white-99");
  EXPECT_EQ(signal(blocked, 30, -31), 0.0);
  EXPECT_EQ(signal(blocked, 30, -34), signal(good, 30, -34));
  EXPECT_EQ(signal(blocked, 30, 30), signal(good, 30, 30));
}

TEST(DiscOverlap, IsTheAreaTwoDiscsShare) {
  EXPECT_EQ(disc_overlap(1, 1, 2.5), 0.0);
  EXPECT_EQ(disc_overlap(1, 3, 1.5), 1.0);
  EXPECT_NEAR(disc_overlap(2, 1, 0.5), 0.25, 1e-12);
  EXPECT_NEAR(disc_overlap(1, 1, 1.0), (2.0 / 3.0 - std::sqrt(3.0) / (2.0 * optics::pi)), 1e-12);
}

TEST(Overfill, LosesTheLightThatMissesTheSampleAtGrazing) {
  PlantConfig config = ideal_config();
  config.beam.over_sample = 0.8;
  Bench over(config, "lambertian-99"), good(ideal_config(), "lambertian-99");
  const auto share = [&](double ti) { return signal(over, ti, 10) / signal(good, ti, 10); };
  EXPECT_NEAR(share(0.0), 1.0 - std::exp(-2.0 / 0.64), 1e-6);
  EXPECT_LT(share(60.0), share(0.0) - 0.1);
  // Far towards grazing the lit length is beyond the sample and the share tends to cos θi.
  EXPECT_NEAR(share(85.5) / share(88.2),
              std::cos(optics::radians(85.5)) / std::cos(optics::radians(88.2)), 0.03);
}

TEST(Underfill, LosesTheSpotThatLeavesTheFieldUnlessTheFieldStretchesWithIt) {
  PlantConfig config = ideal_config();
  config.collection.beam_over_field = 0.8;
  Bench under(config, "lambertian-99"), good(ideal_config(), "lambertian-99");
  const double full = 1.0 - std::exp(-2.0 / 0.64);
  EXPECT_NEAR(signal(under, 0, 0) / signal(good, 0, 0), full, 1e-6);
  EXPECT_LT(signal(under, 70, 0) / signal(good, 70, 0), full - 0.1);
  EXPECT_NEAR(signal(under, 60, 60) / signal(good, 60, 60),
              gaussian_in_ellipse(0.8, 0.4, 2.0, 1.0, 0.0), 1e-5);
}

TEST(StrayLight, AddsTheSameToAllDirectionsAndGoesWithTheShutter) {
  PlantConfig config = ideal_config();
  config.collection.stray_per_sr = 1e-3;
  Bench stray(config, "black-matte"), good(ideal_config(), "black-matte");
  for (const double tr : {-60.0, 10.0, 80.0}) {
    EXPECT_NEAR(signal(stray, 30, tr) - signal(good, 30, tr), 820.0 * 1.5 * 1e-4 * 1e-3, 1e-12);
  }
  stray.plant().set_shutter(false, stray.time_s());
  EXPECT_EQ(signal(stray, 30, 10), 0.0);
  stray.plant().set_shutter(true, stray.time_s());
  stray.wait(1.0);
  stray.plant().arrange({.sample_removed = true});
  EXPECT_NEAR(signal(stray, 30, 10), 820.0 * 1.5 * 1e-4 * 1e-3, 1e-12);
}

TEST(StrayLight, ForwardFallsOffFromTheGrazingDirection) {
  PlantConfig config = ideal_config();
  config.collection.stray_forward_per_sr = 1e-2;
  config.collection.stray_forward_width_deg = 8.0;
  Bench stray(config, "black-matte"), good(ideal_config(), "black-matte");
  const auto extra = [&](double tr) { return signal(stray, 30, tr) - signal(good, 30, tr); };
  EXPECT_NEAR(extra(82.0) / extra(90.0), std::exp(-0.5), 1e-3);
  EXPECT_NEAR(extra(-80.0), 0.0, 1e-12);
}

TEST(Iris, CollectsWithTheSquareOfItsDiameterAndSharpensTheLobe) {
  PlantConfig config = realistic_config();
  config.collection.stray_per_sr = config.collection.stray_forward_per_sr = 0.0;
  Bench bench(config, "black-gloss");
  const double usual = signal(bench, 30, 30);
  bench.plant().arrange({.iris_fraction = 0.5});
  const double small = signal(bench, 30, 30);
  EXPECT_GT(4.0 * small, usual);
  EXPECT_NEAR(4.0 * small / usual, 1.0, 0.03);
}

TEST(RealisticBench, DiffersFromTheIdealByPerCentsNotMore) {
  Bench real(realistic_config(), "white-99"), good(ideal_config(), "white-99");
  for (const double tr : {-60.0, 0.0, 30.0, 60.0}) {
    const double a = signal(real, 30, tr) / real.plant().expected(0.0).monitor_v;
    const double b = signal(good, 30, tr) / good.plant().expected(0.0).monitor_v;
    EXPECT_NEAR(a / b, 1.0, 0.03) << tr;
    EXPECT_NE(a, b);
  }
}

}  // namespace
}  // namespace umov::plant::test
