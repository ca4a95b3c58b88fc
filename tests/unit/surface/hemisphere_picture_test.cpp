// Polar maps of simulated hemispheres.
#include "host/surface/hemisphere_picture.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "host/errors/error.hpp"
#include "host/formats/image_file.hpp"
#include "host/optics/angles.hpp"
#include "host/surface/scene_file.hpp"
#include "tests/unit/formats/scratch_folder.hpp"

namespace umov::surface {
namespace {

const std::string paint =
    "[surface]\nwavelengths_um = [0.5, 0.8]\nperiod_um = 100\n[substrate]\n"
    "model = \"microfacet+lambertian\"\n\"0.slope_rms\" = 0.1\n\"1.rho\" = [0.01, 0.5]\n";

trace::Result simulated(double theta_i_deg) {
  const Surface s = surface_from_toml(paint, "scene.toml", {});
  const trace::Geometry geometry(s.scene);
  const trace::PathTracer tracer(s.scene, geometry);
  trace::Request request;
  request.theta_i = optics::radians(theta_i_deg);
  request.samples = 200'000;
  return trace::simulate(tracer, trace::Hemisphere(12, 0, 0.0), request);
}

TEST(HemisphereMap, HoldsTheReflectanceAndHasTheMirrorDirectionToTheRight) {
  const formats::testing::ScratchFolder folder;
  const auto file = folder / "map.exr";
  const std::vector<trace::Result> results{simulated(0.0), simulated(45.0)};
  write_hemisphere_exr(file, {results, {0.0, 45.0}, {0.5, 0.8}});
  std::size_t width = 0, height = 0;
  const auto inside = formats::read_exr(file, "A", width, height);
  const auto f = formats::read_exr(file, "45deg.500nm.m00", width, height);
  const auto u = formats::read_exr(file, "45deg.500nm.m00_se", width, height);
  const auto grey = formats::read_exr(file, "0deg.800nm.m00", width, height);
  ASSERT_EQ(width, 121u);
  ASSERT_EQ(height, 121u);
  const double half = 0.5 * static_cast<double>(width);
  double dhr = 0.0, dhr_grey = 0.0;
  std::size_t brightest = 0;
  for (std::size_t i = 0; i < f.size(); ++i) {
    const double x = (static_cast<double>(i % width) + 0.5 - half) / half;
    const double y = (half - static_cast<double>(i / width) - 0.5) / half;
    const double radius = std::max(1e-9, std::hypot(x, y));
    EXPECT_EQ(inside[i], radius < 1.0 ? 1.0 : 0.0);
    if (radius >= 1.0) continue;
    // dΩ = sin θ dθ dφ, of a pixel of dx dy = r dr dφ with θ = r π/2.
    const double theta = 0.5 * optics::pi * radius;
    const double weight =
        std::cos(theta) * std::sin(theta) * 0.5 * optics::pi / radius / (half * half);
    dhr += weight * f[i];
    dhr_grey += weight * grey[i];
    if (f[i] > f[brightest]) brightest = i;
  }
  EXPECT_NEAR(dhr, results[1].hemispherical(0).mean[0][0], 0.02 * dhr);
  EXPECT_NEAR(dhr_grey, results[0].hemispherical(1).mean[0][0], 0.02 * dhr_grey);
  EXPECT_NEAR(static_cast<double>(brightest % width), half * 1.5, 8.0);
  EXPECT_NEAR(static_cast<double>(brightest / width), half, 8.0);
  EXPECT_GT(u[brightest], 0.0);
  EXPECT_LT(u[brightest], 0.05 * f[brightest]);
  EXPECT_THROW(formats::read_exr(file, "30deg.500nm.m00", width, height), Error);
}

TEST(HemisphereMap, IsAPictureWhoseColoursFollowTheValues) {
  const trace::Result dark = simulated(45.0);
  const std::string size = hemisphere_png(dark, 45.0, 0.5, 0, 0, 0);
  ASSERT_GT(size.size(), 1000u);
  EXPECT_EQ(size.substr(0, 8), "\x89PNG\r\n\x1a\n");
  EXPECT_NE(size, hemisphere_png(dark, 45.0, 0.8, 1, 0, 0));
  EXPECT_NE(size, hemisphere_png(dark, 45.0, 0.5, 0, 1, 0));
  EXPECT_EQ(size, hemisphere_png(dark, 45.0, 0.5, 0, 0, 0));
}

}  // namespace
}  // namespace umov::surface
