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
#include "tests/unit/surface/plain_spheres.hpp"

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

Diagnosis diagnosed(const formats::BrdfTable& table, const std::string& scene,
                    std::uint64_t samples = launches) {
  SurfaceModelOptions options;
  options.samples = samples;
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

// Truths of which no ray is traced by the engine that the diagnosis simulates with.

const std::string grains =
    "[surface]\nwavelengths_um = [0.5, 0.8]\nperiod_um = 800\n"
    "[substrate]\nmodel = \"lambertian\"\nrho = [0.05, 0.5]\n"
    "[[particles]]\nmaterial = \"clay\"\nradius_um = 20\ncoverage = 0.3\n"
    "[materials.clay]\nmodel = \"lambertian\"\nrho = [0.1, 0.9]\n";

formats::BrdfTable plainly_traced(int most_bounces) {
  surface::PlainSpheres truth{400.0, 20.0, 0.3, {0.05, 0.5}, {0.1, 0.9}};
  truth.most_bounces = most_bounces;
  auto table = truth.measured(trace::Hemisphere(rings, 0, 0.0), 40.0, {500.0, 800.0}, 256, 2000, 5);
  // Both bands have the same rays. An instrument's noise is new in each value, and here it is more.
  std::mt19937_64 random(6);
  std::normal_distribution<double> normal;
  auto& points = table.points;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double u = 0.03 * points.brdf_per_sr[i];
    points.brdf_per_sr[i] += u * normal(random);
    points.brdf_u[i] = std::hypot(u, points.brdf_u[i]);
  }
  return table;
}

TEST(SurfaceGapByAnotherRoute, ShadowingAndFurtherBouncesOfPlainlyTracedSpheresAreNamed) {
  // What is simulated must be known better than what was measured.
  const Diagnosis d = diagnosed(plainly_traced(1000), grains, 4 * launches);
  EXPECT_THAT(names(d), UnorderedElementsAre("particle_shadowing", "multiple_scattering"));
  EXPECT_NEAR(size_of(d, "particle_shadowing"), 1.0, 0.15);
  EXPECT_NEAR(size_of(d, "multiple_scattering"), 1.0, 0.25);
}

TEST(SurfaceGapByAnotherRoute, ShadowingAloneOfPlainlyTracedSpheresIsNamed) {
  const Diagnosis d = diagnosed(plainly_traced(1), grains, 4 * launches);
  EXPECT_THAT(names(d), UnorderedElementsAre("particle_shadowing"));
  EXPECT_NEAR(size_of(d, "particle_shadowing"), 1.0, 0.15);
}

// Fresnel's coefficients as powers, from vacuum into an index n (or out of 1/n), by their textbook
// form.
struct Powers {
  double s, p;
};
Powers fresnel(double n, double cosine) {
  const double sine2 = (1.0 - cosine * cosine) / (n * n);
  if (sine2 >= 1.0) return {1.0, 1.0};
  const double inside = std::sqrt(1.0 - sine2);
  return {std::pow((cosine - n * inside) / (cosine + n * inside), 2),
          std::pow((n * cosine - inside) / (n * cosine + inside), 2)};
}

// `share` of a Lambertian ground below a smooth film of water, the rest dry: Saunderson's series in
// closed form, with the polarisation that the way out gives, and 1 % of noise.
formats::BrdfTable film_by_formula(double rho, double share) {
  constexpr double n = 1.332;
  double back = 0.0;  // from below, of diffuse light
  constexpr int steps = 20000;
  for (int i = 0; i < steps; ++i) {
    const double cosine = (i + 0.5) / steps;
    const Powers r = fresnel(1.0 / n, cosine);
    back += 2.0 * cosine * 0.5 * (r.s + r.p) / steps;
  }
  const trace::Hemisphere cells(rings, 0, 0.0);
  const double theta_i = optics::radians(40.0);
  const Powers in = fresnel(n, std::cos(theta_i));
  const double entering = 1.0 - 0.5 * (in.s + in.p);
  const std::size_t mirror = cells.find(optics::exit_direction(theta_i, 0.0));
  std::mt19937_64 random(6);
  std::normal_distribution<double> normal;
  formats::BrdfTable table;
  auto& m = table.mueller.emplace();
  m.side = 3;
  for (std::size_t i = 0; i < cells.cells(); ++i) {
    const trace::Cell cell = cells.cell(i);
    double out = 0.0;
    double out_q = 0.0;
    constexpr int points = 32;  // weighted by cos θr
    for (int j = 0; j < points; ++j) {
      const double low = std::pow(std::sin(cell.theta_low), 2);
      const double high = std::pow(std::sin(cell.theta_high), 2);
      const Powers r = fresnel(n, std::sqrt(1.0 - low - (j + 0.5) / points * (high - low)));
      out += (1.0 - 0.5 * (r.s + r.p)) / points;
      out_q += 0.5 * (r.p - r.s) / points;
    }
    const double body = entering * rho / (optics::pi * n * n * (1.0 - rho * back));
    double f = share * body * out + (1.0 - share) * rho / optics::pi;
    double q = share * body * out_q;
    if (i == mirror) {
      f += share * 0.5 * (in.s + in.p) / cell.projected;
      q += share * 0.5 * (in.s - in.p) / cell.projected;
    }
    const double error = 0.01 * f;
    m.theta_i_deg.push_back(40.0);
    m.theta_r_deg.push_back(optics::degrees(0.5 * (cell.theta_low + cell.theta_high)));
    m.phi_r_deg.push_back(
        std::remainder(optics::degrees(0.5 * (cell.phi_low + cell.phi_high)), 360.0));
    m.wavelength_nm.push_back(600.0);
    for (int e = 0; e < 9; ++e) {
      const double value = e == 0 ? f : e == 3 ? q : std::nan("");
      m.mueller.push_back(value + error * normal(random));
      m.mueller_u.push_back(error);
    }
  }
  return table;
}

TEST(SurfaceGapByAnotherRoute, AWaterFilmOfClosedFormIsNamedWithItsCoverage) {
  for (const double share : {0.5, 1.0}) {
    const Diagnosis d = diagnosed(film_by_formula(0.4, share), wet_paint);
    EXPECT_THAT(names(d), UnorderedElementsAre("water_film")) << share;
    EXPECT_NEAR(size_of(d, "water_film"), share, 0.1);
  }
  EXPECT_EQ(diagnosed(film_by_formula(0.4, 0.0), wet_paint).verdict, Verdict::none_needed);
}

TEST(SurfaceGap, RefusesOtherWavelengths) {
  EXPECT_THROW(SurfaceModel(measured(wet_paint), dirt, "scene.toml"), Error);
  EXPECT_THROW(SurfaceModel(formats::BrdfTable{}, dirt, "scene.toml"), Error);
}

}  // namespace
}  // namespace umov::gap
