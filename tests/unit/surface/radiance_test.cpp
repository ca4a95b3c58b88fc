// Emitted and reflected light in one equation.
#include "host/surface/radiance.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "host/optics/fresnel.hpp"

namespace umov::surface {
namespace {

using optics::radians;

struct Viewed {
  Surface surface;
  std::vector<ViewedRadiance> bands;
  trace::MuellerEstimate all;
};

Viewed viewed(const std::string& text, double theta_deg) {
  Viewed v{surface_from_toml(text, "scene.toml", {}), {}, {}};
  const trace::Geometry geometry(v.surface.scene);
  const trace::PathTracer tracer(v.surface.scene, geometry);
  trace::Request request;
  request.theta_i = radians(theta_deg);
  request.samples = 1 << 17;
  request.emissivity = true;
  const trace::Result result = trace::simulate(tracer, trace::Hemisphere(9, 0, 0.0), request);
  v.bands = viewed_radiance(result, v.surface.scene, *v.surface.emission);
  v.all = result.hemispherical(0);
  return v;
}

const std::string wet_dirt =
    "[substrate]\nmodel = \"lambertian\"\nrho = 0.3\n"
    "[[particles]]\nmaterial = \"clay\"\nradius_um = 20\ncoverage = 0.3\n"
    "[materials.clay]\nmodel = \"lambertian\"\nrho = 0.6\n"
    "[[drops]]\nradius_um = 20\ncontact_angle_deg = 90\ncoverage = 0.2\n";

TEST(BlackBody, IsPlancksLaw) {
  // Wien's peak of 300 K at 9.659 µm, and its Stefan-Boltzmann sum σT⁴/π.
  double sum = 0.0;
  double peak = 0.0;
  double at = 0.0;
  for (double w = 0.5; w < 400.0; w += 0.005) {
    const double b = black_body(w, 300.0);
    sum += 0.005 * b;
    if (b > peak) {
      peak = b;
      at = w;
    }
  }
  EXPECT_NEAR(at, 2897.771955 / 300.0, 0.01);
  EXPECT_NEAR(sum, 5.670374419e-8 * std::pow(300.0, 4) / 3.14159265358979, 0.05);
  EXPECT_EQ(black_body(4.0, 0.0), 0.0);
  double sun = 0.0;
  for (double w = 0.1; w < 60.0; w += 0.001) sun += 0.001 * sun_irradiance(w);
  EXPECT_NEAR(sun, 1361.0, 2.0) << "the solar constant, W/m²";
}

TEST(Radiance, OfASceneAndASkyOfOneTemperatureIsThatOfABlackBody) {
  const Viewed v = viewed("[surface]\nwavelengths_um = [3.0, 4.0, 5.0]\n" + wet_dirt +
                              "[emission]\ntemperature_k = 300\nsky_temperature_k = 300\n",
                          60.0);
  ASSERT_EQ(v.bands.size(), 3u);
  for (const ViewedRadiance& band : v.bands) {
    const double black = black_body(band.wavelength_um, 300.0);
    EXPECT_NEAR(band.total / black, 1.0, 2e-3);
    EXPECT_GT(band.reflected_sky, 0.05 * black);
    EXPECT_NEAR(band.stokes_1 / black, 0.0, 4e-3) << "black bodies are not polarised";
  }
}

TEST(Radiance, OfASmoothMetalIsPolarisedAndGoesWithItsTemperature) {
  const std::string metal =
      "[surface]\nwavelengths_um = [4.0]\n[substrate]\nmodel = \"fresnel\"\nn = 3.0\nkappa = 5.0\n"
      "temperature_k = 400\n[emission]\ntemperature_k = 300\n";
  const Viewed v = viewed(metal, 70.0);
  const auto r = optics::fresnel_reflection(3.0, 5.0, std::cos(radians(70.0)));
  EXPECT_NEAR(v.bands[0].emissivity, 1.0 - r.mean, 1e-9);
  EXPECT_NEAR(v.bands[0].total, (1.0 - r.mean) * black_body(4.0, 400.0), 1e-6);
  EXPECT_NEAR(v.bands[0].stokes_1, -r.half_difference * black_body(4.0, 400.0), 1e-6)
      << "a metal emits more p than s";
}

TEST(Radiance, OfASunlitPaintIsItsReflectanceTimesTheSun) {
  const Viewed v = viewed(
      "[surface]\nwavelengths_um = [4.0]\n[substrate]\nmodel = \"lambertian\"\nrho = 0.4\n"
      "[emission]\ntemperature_k = 300\nsun_theta_deg = 30\n",
      20.0);
  const double sun = 0.4 / 3.14159265358979 * sun_irradiance(4.0) * std::cos(radians(30.0));
  EXPECT_NEAR(v.bands[0].reflected_sun, sun, 5.0 * v.bands[0].reflected_sun_u);
  EXPECT_LT(v.bands[0].reflected_sun_u, 0.05 * sun);
  EXPECT_NEAR(v.bands[0].emitted, 0.6 * black_body(4.0, 300.0), 1e-9);
  EXPECT_GT(sun / v.bands[0].emitted, 0.5) << "3 to 5 µm: as much sun as heat";
}

}  // namespace
}  // namespace umov::surface
