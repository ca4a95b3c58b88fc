// What linear mixing in single bounce leaves out of a measured surface, named without being told.
#include "host/gap/surface/surface_model.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <string>

#include "host/errors/error.hpp"
#include "host/gap/engine/diagnosis.hpp"
#include "host/optics/angles.hpp"
#include "host/surface/brdf_export.hpp"
#include "host/surface/scene_file.hpp"

namespace umov::gap {
namespace {

using ::testing::UnorderedElementsAre;

constexpr std::uint64_t launches = 1 << 17;
constexpr std::size_t rings = 9;

const std::string dirt =
    "[surface]\nwavelengths_um = [0.5, 0.8]\nperiod_um = 1500\n"
    "[substrate]\nmodel = \"microfacet+lambertian\"\n\"0.slope_rms\" = 0.2\n\"1.rho\" = [0.1, "
    "0.4]\n"
    "[[particles]]\nmaterial = \"clay\"\nradius_um = 20\ncoverage = 0.3\n"
    "[materials.clay]\nmodel = \"lambertian\"\nrho = [0.4, 0.6]\n";
const std::string rough =
    "[surface]\nwavelengths_um = [0.6]\nperiod_um = 1000\n"
    "[substrate]\nmodel = \"lambertian\"\nrho = 0.8\n"
    "rough = { slope_rms = 0.7, correlation_um = 30 }\n";
const std::string wet_paint =
    "[surface]\nwavelengths_um = [0.6]\nperiod_um = 1000\n"
    "[substrate]\nmodel = \"lambertian\"\nrho = 0.4\n";

// What somebody measured of `scene`: other particles of the kind, other rays.
formats::BrdfTable measured(const std::string& scene, std::uint32_t most_meetings = 0,
                            surface::Reading reading = {}) {
  reading.seed = 77;
  const surface::Surface s = surface::surface_from_toml(scene, "truth", reading);
  const trace::Geometry geometry(s.scene);
  const trace::PathTracer tracer(s.scene, geometry);
  formats::BrdfTable all;
  trace::Request request;
  request.seed = 78;
  request.samples = launches;
  request.theta_i = optics::radians(40.0);
  request.most_meetings = most_meetings;
  return surface::brdf_table(
      simulate(tracer, trace::Hemisphere(rings, 180, optics::radians(2.0)), request), s.scene, 40.0,
      surface::Directions::cells);
}

Diagnosis diagnosed(const formats::BrdfTable& table, const std::string& scene) {
  SurfaceModelOptions options;
  options.samples = launches;
  options.rings = rings;
  options.coverage_factors = {0.6, 1.0, 1.4};
  const SurfaceModel model(table, scene, "scene.toml", options);
  DiagnoseOptions how;
  how.draws = 100;
  return diagnose(model, how);
}

std::vector<std::string> names(const Diagnosis& d) {
  std::vector<std::string> all;
  for (const Cause& c : d.causes) all.push_back(c.effect);
  return all;
}

double size_of(const Diagnosis& d, const std::string& effect) {
  for (const Cause& c : d.causes) {
    if (c.effect == effect) return c.parameters[0].interval.value;
  }
  return std::nan("");
}

TEST(SurfaceGap, ParticleShadowingAndFurtherBouncesAreNamedOverALinearMixture) {
  const Diagnosis d = diagnosed(measured(dirt), dirt);
  EXPECT_THAT(names(d), UnorderedElementsAre("particle_shadowing", "multiple_scattering"));
  EXPECT_NEAR(size_of(d, "particle_shadowing"), 1.0, 0.15);
  EXPECT_NEAR(size_of(d, "multiple_scattering"), 1.0, 0.25);
  EXPECT_GT(d.closed_fraction.lo, 0.9);
}

TEST(SurfaceGap, ShadowingAloneIsNamedWhereLightBouncesOnce) {
  const Diagnosis d = diagnosed(measured(dirt, 1), dirt);
  EXPECT_THAT(names(d), UnorderedElementsAre("particle_shadowing"));
}

TEST(SurfaceGap, FurtherBouncesOnRoughGroundAreNamed) {
  const Diagnosis d = diagnosed(measured(rough), rough);
  EXPECT_THAT(names(d), UnorderedElementsAre("multiple_scattering"));
  EXPECT_NEAR(size_of(d, "multiple_scattering"), 1.0, 0.2);
}

TEST(SurfaceGap, AWaterFilmOnADryPaintIsNamedWithItsCoverage) {
  const auto wet = measured(wet_paint + "[film]\nthickness_um = 10\n");
  const Diagnosis d = diagnosed(wet, wet_paint + "# no [film] is known of\n");
  EXPECT_THAT(names(d), UnorderedElementsAre("water_film"));
  EXPECT_NEAR(size_of(d, "water_film"), 1.0, 0.1);
}

TEST(SurfaceGap, NothingIsNamedWhereNothingIsLeftOut) {
  EXPECT_EQ(diagnosed(measured(rough, 1), rough).verdict, Verdict::none_needed);
  EXPECT_EQ(diagnosed(measured(wet_paint), wet_paint).verdict, Verdict::none_needed);
}

TEST(SurfaceGap, RefusesOtherWavelengths) {
  EXPECT_THROW(SurfaceModel(measured(wet_paint), dirt, "scene.toml"), Error);
  EXPECT_THROW(SurfaceModel(formats::BrdfTable{}, dirt, "scene.toml"), Error);
}

}  // namespace
}  // namespace umov::gap
