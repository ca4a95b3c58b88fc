// What lies on a sample: each alone, by what it must do to the light.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "expected_signal.hpp"
#include "hil/plant/coating.hpp"
#include "hil/plant/diffuser_sample.hpp"
#include "hil/plant/facet_sample.hpp"
#include "hil/plant/mirror_sample.hpp"
#include "hil/plant/quadrature.hpp"
#include "hil/plant/water.hpp"
#include "host/optics/fresnel.hpp"

namespace umov::plant::test {
namespace {

std::shared_ptr<const Sample> lambertian(double albedo) {
  DiffuserParameters p;
  p.dhr = Spectrum(albedo);
  return std::make_shared<DiffuserSample>("lambertian", p);
}

double f00(const Sample& sample, double ti, double tr, double phi = 0.0, double nm = 633.0) {
  return optics::element(brdf_at(sample, ti, tr, phi, nm), 0, 0);
}

TEST(Coating, WithNothingOnItIsTheVerySameSample) {
  const auto sample = lambertian(0.5);
  EXPECT_EQ(coated(sample, ideal_config()), sample);
  EXPECT_EQ(coated(sample, realistic_config()), sample);
}

TEST(Coating, LiesOnTheInstrumentsOwnSampleAndNotOnATileInItsPlace) {
  PlantConfig config = ideal_config();
  config.dust.optical_depth_633 = 0.2;
  const std::shared_ptr<const Sample> own = make_sample("white-99");
  Bench bench(config, own), clean(ideal_config(), own);
  const double dusty = signal(bench, 30, 10);
  EXPECT_NE(dusty, signal(clean, 30, 10));
  bench.plant().place_sample(make_sample("white-99"));
  EXPECT_EQ(signal(bench, 30, 10), signal(clean, 30, 10));
  bench.plant().place_sample(own);
  EXPECT_EQ(signal(bench, 30, 10), dusty);
}

TEST(Dust, ThinsTheLightTwiceAndMoreAtShortWavelengths) {
  DustConfig dust{0.05, 0.6, 0.0};  // black dust
  PlantConfig config;
  config.dust = dust;
  const auto below = lambertian(0.9);
  const auto sample = coated(below, config);
  for (const double nm : {532.0, 633.0, 814.0}) {
    for (const double tr : {-50.0, 0.0, 70.0}) {
      const double path =
          1.0 / std::cos(optics::radians(40.0)) + 1.0 / std::cos(optics::radians(tr));
      EXPECT_NEAR(f00(*sample, 40, tr, 0, nm) / f00(*below, 40, tr, 0, nm),
                  std::exp(-0.05 * 633.0 / nm * path), 1e-12);
    }
  }
}

TEST(Dust, ScattersAllThatItTakesWhenItDoesNotAbsorb) {
  // Over a black sample, thin dust without absorption sends back the light that it scatters
  // upwards; with g = 0 that is half of what it takes from the beam.
  PlantConfig config;
  config.dust = {1e-4, 0.0, 1.0};
  const auto sample = coated(lambertian(0.0), config);
  EXPECT_NEAR(dhr(*sample, 40, 633).unpolarized, 0.5 * 1e-4 / std::cos(optics::radians(40.0)),
              3e-7);
  // Forward scattering favours the forward side.
  config.dust.g = 0.7;
  const auto forward = coated(lambertian(0.0), config);
  EXPECT_GT(f00(*forward, 60, 70), 5.0 * f00(*forward, 60, -40));
}

TEST(Dust, IsReciprocal) {
  PlantConfig config;
  config.dust = {0.1, 0.7, 0.9};
  const auto sample = coated(lambertian(0.3), config);
  EXPECT_NEAR(f00(*sample, 20, 65, 50), f00(*sample, 65, 20, 50), 1e-14);
}

TEST(WaterFilm, DarkensADiffuserAndAddsItsOwnGloss) {
  PlantConfig config;
  config.film = {1.0, 0.02};
  const auto dry = lambertian(0.5);
  const auto wet = coated(dry, config);
  EXPECT_LT(f00(*wet, 45, -20), 0.8 * f00(*dry, 45, -20));
  // At the mirror direction: Fresnel of water over 4 cos² and the slopes' density.
  const double gloss = f00(*wet, 45, 45) - f00(*wet, 45, 43.9 - 45.0 + 20.0);
  const double fresnel = optics::reflectance(1.332, 0.0, std::cos(optics::radians(45.0)));
  const double facet = fresnel / (2.0 * optics::pi * 0.02 * 0.02 * 4.0 * 0.5);
  EXPECT_NEAR(gloss / facet, 1.0, 0.02);
}

TEST(WaterFilm, OverAWhiteSampleLosesAlmostNothing) {
  // All light comes back when nothing absorbs, whatever the interface does. The diffuse series is
  // exact for a Lambertian; directions through the interface are Fresnel's.
  PlantConfig config;
  config.film = {1.0, 0.05};
  const auto wet = coated(lambertian(1.0), config);
  EXPECT_NEAR(dhr(*wet, 0, 633).unpolarized, 1.0, 0.01);
  EXPECT_NEAR(dhr(*wet, 50, 633).unpolarized, 1.0, 0.02);
}

TEST(WaterFilm, CoversItsShareOfTheArea) {
  PlantConfig half;
  half.film = {0.5, 0.03};
  PlantConfig whole = half;
  whole.film.coverage = 1.0;
  const std::shared_ptr<const Sample> dry = make_sample("red-gloss");
  const double mean = 0.5 * (f00(*dry, 40, 30) + f00(*coated(dry, whole), 40, 30));
  EXPECT_NEAR(f00(*coated(dry, half), 40, 30), mean, 1e-12);
}

TEST(WaterFilm, TransmissionKeepsToTheEnergyThatTheInterfaceLeavesPolarised) {
  // Through a level film over a polarisation-keeping mirror-like lobe, s light is T_s² of the inner
  // lobe: near Brewster's angle of water p passes whole and s does not.
  PlantConfig config;
  config.film = {1.0, 0.5};
  FacetParameters p;
  p.lobes[0].slope = 0.1;
  const auto dry = std::make_shared<FacetSample>("facets", p);
  const Wetted wetted(dry);
  const double n = wetted.index(633.0);
  const double ti = std::atan(n);
  const Beam in = optics::incident_beam(ti);
  const Beam out = optics::exit_beam(ti, 0.0);
  const Vec3 up(0, 0, 1);
  const Mueller m = wetted.through(in, up, out, up, 633.0);
  const double inside = std::asin(std::sin(ti) / n);
  const auto under = dry->immersed(n);
  const Mueller inner =
      under->brdf(optics::incident_beam(inside), optics::exit_beam(inside, 0.0), 633.0);
  const double s = 1.0 - optics::reflectance_s(n, 0.0, std::cos(ti));
  const double inner_s = optics::element(inner, 0, 0) + optics::element(inner, 0, 1);
  const double inner_p = optics::element(inner, 0, 0) - optics::element(inner, 0, 1);
  const double outer_s = optics::element(m, 0, 0) + optics::element(m, 0, 1);
  const double outer_p = optics::element(m, 0, 0) - optics::element(m, 0, 1);
  EXPECT_NEAR(outer_s, s * s * inner_s / (n * n), 1e-9);
  EXPECT_NEAR(outer_p, inner_p / (n * n), 1e-9);
}

TEST(WaterDrops, ReflectWithinTheConeOfTheirNormalsOnly) {
  PlantConfig config;
  config.drops = {0.5, 15.0};
  const auto black = lambertian(0.0);
  const auto wet = coated(black, config);
  // Half vectors within 15° of the normal: exits within 30° of the mirror direction.
  EXPECT_GT(f00(*wet, 30, 55), 0.0);
  EXPECT_GT(f00(*wet, 30, 5), 0.0);
  EXPECT_EQ(f00(*wet, 30, 62), 0.0);
  EXPECT_EQ(f00(*wet, 30, -5), 0.0);
  // What they reflect off their tops is Fresnel's share of the light on them.
  const double normal = optics::reflectance(1.332, 0.0, 1.0);
  double reflected = 0.0;
  constexpr int rings = 2000;
  for (int i = 0; i < rings; ++i) {
    const double theta = 0.5 * optics::pi * (i + 0.5) / rings;
    reflected += f00(*wet, 0, optics::degrees(theta)) * std::cos(theta) * std::sin(theta) *
                 optics::pi * optics::pi / rings;
  }
  EXPECT_NEAR(reflected, 0.5 * normal, 0.005 * normal);
}

TEST(NearSpecularLobe, IsNarrowAboutTheMirrorDirectionAtAllWavelengths) {
  PlantConfig config;
  config.marks.lobe_weight = 0.01;
  config.marks.lobe_slope = 0.02;
  const std::shared_ptr<const Sample> plain = make_sample("black-matte");
  const auto marked = coated(plain, config);
  const auto extra = [&](double tr, double nm) {
    return f00(*marked, 30, tr, 0, nm) - f00(*plain, 30, tr, 0, nm);
  };
  EXPECT_GT(extra(30, 633), 0.05);
  EXPECT_NEAR(extra(30, 532), extra(30, 814), 1e-12);
  // A facet turned by one rms slope sends light two slopes away.
  EXPECT_NEAR(extra(30.0 + optics::degrees(0.04), 633) / extra(30, 633), std::exp(-0.5), 0.05);
  EXPECT_LT(extra(45, 633), 1e-9);
}

TEST(RetroreflectionPeak, StandsWhereTheLightComesFrom) {
  PlantConfig config;
  config.marks.retro_peak_per_sr = 0.2;
  config.marks.retro_width_deg = 2.0;
  const auto plain = lambertian(0.3);
  const auto marked = coated(plain, config);
  const auto extra = [&](double tr) { return f00(*marked, 30, tr) - f00(*plain, 30, tr); };
  EXPECT_NEAR(extra(-30), 0.2, 1e-9);
  EXPECT_NEAR(extra(-32), 0.2 * std::exp(-0.5), 1e-6);
  EXPECT_NEAR(extra(30), 0.0, 1e-12);
}

TEST(Fluorescence, IsExcitedByGreenAloneAndPassesTheLongPassFilter) {
  PlantConfig config = ideal_config();
  config.marks.fluorescence_yield_532 = 0.1;
  Bench bench(config, "black-matte"), plain(ideal_config(), "black-matte");
  const auto extra = [&](int laser) {
    return signal(bench, 30, 10, 0, {open, open, laser}) -
           signal(plain, 30, 10, 0, {open, open, laser});
  };
  const double lambert = 0.1 / optics::pi * std::cos(optics::radians(10.0)) * 1e-4;
  EXPECT_NEAR(extra(0), 760.0 * 1.6 * lambert, 1e-6 * extra(0));
  EXPECT_EQ(extra(1), 0.0);
  EXPECT_EQ(extra(2), 0.0);
  // Unpolarised, whatever comes in.
  const double crossed =
      signal(bench, 30, 10, 0, {0, 90, 0}) - signal(plain, 30, 10, 0, {0, 90, 0});
  EXPECT_NEAR(crossed, 0.25 * extra(0), 1e-6 * extra(0));
  bench.plant().arrange({.long_pass = true});
  plain.plant().arrange({.long_pass = true});
  EXPECT_EQ(signal(plain, 30, 10, 0, {open, open, 0}), 0.0);
  EXPECT_NEAR(signal(bench, 30, 10, 0, {open, open, 0}), 760.0 * 1.6 * lambert, 1e-9);
}

TEST(CoatFringes, RunWithTheAngleAndTheWavelength) {
  PlantConfig config;
  config.marks.fringe_contrast = 0.1;
  config.marks.fringe_thickness_um = 10.0;
  const auto plain = lambertian(0.3);
  const auto marked = coated(plain, config);
  const double optical_path = 4.0 * optics::pi * 1.5 * 10.0;
  for (const double nm : {532.0, 633.0}) {
    const double inside = std::sqrt(1.0 - 0.25 / 2.25);  // θd = 30° in index 1.5
    EXPECT_NEAR(f00(*marked, 30, 30, 0, nm) / f00(*plain, 30, 30, 0, nm),
                1.0 + 0.1 * std::cos(optical_path * inside / (1e-3 * nm)), 1e-9);
  }
}

TEST(PatchyPlate, ChangesWithTheWalkOfTheBeam) {
  PlantConfig config;
  config.marks.gradient_per_mm = 0.02;
  config.marks.beam_offset_mm = 1.0;
  const auto plain = lambertian(0.3);
  const auto marked = coated(plain, config);
  EXPECT_NEAR(f00(*marked, 0, 20) / f00(*plain, 0, 20), 1.02, 1e-9);
  EXPECT_NEAR(f00(*marked, 60, 20) / f00(*plain, 60, 20), 1.04, 1e-9);
}

}  // namespace
}  // namespace umov::plant::test
