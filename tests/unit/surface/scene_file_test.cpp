// Scene files: what they describe, and what they refuse.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "host/errors/error.hpp"
#include "host/surface/scene_file.hpp"
#include "host/trace/simulation.hpp"
#include "tests/unit/failure.hpp"

namespace umov::surface {
namespace {

const std::string head = "[surface]\nwavelengths_um = [0.5, 0.7]\nperiod_um = 1000\n[substrate]\n";
const std::string paint = "model = \"lambertian\"\nrho = [0.04, 0.05]\n";
const std::string dirt = "[[particles]]\nmaterial = \"dry_soil\"\nradius_um = 20\n";
const std::string drops = "[[drops]]\nradius_um = 30\n";

Surface surface(const std::string& text, std::uint64_t seed = 1) {
  return surface_from_toml(text, "scene.toml", {.seed = seed});
}

std::string refusal(const std::string& text) {
  return failure_of([&] { surface(text); });
}

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(SceneFile, DescribesDirtAndDropsOnPaint) {
  const Surface s = surface(head + paint + dirt + "coverage = 0.2\n" + drops +
                            "contact_angle_deg = 15\ncoverage = 0.1\n");
  ASSERT_EQ(s.layers.size(), 2u);
  EXPECT_NEAR(s.layers[0].coverage, 0.2, 0.001);
  EXPECT_NEAR(s.layers[1].coverage, 0.1, 0.002);
  EXPECT_NEAR(s.covered, 0.3, 0.002);
  EXPECT_EQ(s.scene.spheres.size(), s.layers[0].count + s.layers[1].count);
  const trace::Sphere& drop = s.scene.spheres.back();
  // A cap of 15° that is 60 µm wide is 30·tan(7.5°) high.
  EXPECT_NEAR(drop.centre.z + drop.radius, 30.0 * std::tan(0.5 * 15.0 / 57.29577951308232), 1e-9);
  EXPECT_EQ(drop.base_z, 0.0);
  EXPECT_NEAR(s.scene.media[1].n[0], 1.335, 0.003);
  const auto& soil = std::get<trace::Lambertian>(s.scene.materials[s.layers[0].material]);
  EXPECT_EQ(soil.albedo[0], 0.2333);
  EXPECT_EQ(soil.albedo[1], 0.3355);
}

TEST(SceneFile, TakesSpectraAsTablesAndMaterialsByName) {
  const Surface s = surface(
      "[surface]\nwavelengths_um = { from = 0.5, to = 0.6, step = 0.05 }\ntheta_i_deg = [20, 60]\n"
      "[substrate]\nmodel = \"microfacet+lambertian\"\n\"0.n\" = 1.5\n"
      "\"1.rho\" = { wavelength_um = [0.4, 0.8], value = [0.1, 0.5] }\n"
      "[[particles]]\nmaterial = \"clay\"\nradius_um = 10\ncoverage = 0.1\n"
      "[materials.clay]\nmodel = \"lambertian\"\n"
      "rho = { wavelength_um = [0.4, 0.6], value = [0.2, 0.4] }\n"
      "[stop]\ndhr_relative_error = 0.02\nmax_rays = 1e9\n");
  const auto& clay = std::get<trace::Lambertian>(s.scene.materials[s.layers[0].material]);
  EXPECT_NEAR(clay.albedo[0], 0.3, 1e-12);
  EXPECT_NEAR(clay.albedo[1], 0.35, 1e-12);
  EXPECT_NEAR(clay.albedo[2], 0.4, 1e-12);
  EXPECT_EQ(s.theta_i_deg, (std::vector<double>{20.0, 60.0}));
  EXPECT_EQ(s.stop.dhr_relative_error, 0.02);
  EXPECT_EQ(s.stop.rays, 1e9);
  EXPECT_NEAR(static_cast<double>(s.layers[0].count), 1000.0, 3.0) << "the period was left open";
}

TEST(SceneFile, OfAModelOrRoughMetalCanBeTraced) {
  const Surface model =
      surface(head + "model = \"microfacet+lambertian\"\n\"0.n\" = 1.5\n\"1.rho\" = [0.1, 0.4]\n");
  const Surface rough = surface(head +
                                "model = \"fresnel\"\nn = 1.2\nkappa = 7\n"
                                "rough = { slope_rms = 0.2, correlation_um = 60, cells = 128 }\n");
  for (const Surface& s : {model, rough}) {
    const trace::Geometry geometry(s.scene);
    const trace::PathTracer tracer(s.scene, geometry);
    trace::Request request;
    request.samples = 4096;
    request.block = 256;
    const auto result = trace::simulate(tracer, trace::Hemisphere(3, 0, 0.0), request);
    const double dhr = result.hemispherical(1).mean[0][0];
    EXPECT_GT(dhr, 0.3);
    EXPECT_LT(dhr, 1.0);
    EXPECT_EQ(result.ledger().lost[0], 0.0);
  }
}

TEST(SceneFile, KeepsThePartsOfAMixtureApart) {
  const std::string text =
      head + paint + dirt + "coverage = 0.2\n" + drops + "contact_angle_deg = 90\ncoverage = 0.1\n";
  const auto part = [&](Part which, std::size_t layer) {
    return surface_from_toml(text, "scene.toml", {.part = which, .layer = layer});
  };
  EXPECT_TRUE(part(Part::bare, 0).scene.spheres.empty());
  EXPECT_EQ(part(Part::bare, 0).scene.meshes.size(), 1u);
  const Surface soil = part(Part::contaminant, 0);
  ASSERT_EQ(soil.scene.meshes.size(), 1u);
  EXPECT_EQ(std::get<trace::Lambertian>(soil.scene.materials[soil.scene.meshes[0].materials[0]])
                .albedo[0],
            0.2333);
  const Surface film = part(Part::contaminant, 1);
  EXPECT_EQ(film.scene.meshes.size(), 2u) << "paint below water";
  EXPECT_THROW(part(Part::contaminant, 2), Error);
}

TEST(SceneFile, SaysWhichCellsARunStopsBy) {
  const Stop median = surface(head + paint + "[stop]\ncell_relative_error = 0.03\n").stop;
  EXPECT_EQ(median.cell_relative_error, 0.03);
  EXPECT_EQ(median.cell_percentile, 50.0);
  EXPECT_FALSE(median.cell_deg);
  const std::string most = "[stop]\ncell_relative_error = 0.03\ncell_percentile = 90\n";
  EXPECT_EQ(surface(head + paint + most).stop.cell_percentile, 90.0);
  const std::string one = "[stop]\ncell_relative_error = 0.03\ncell_deg = [30, -90]\n";
  const Stop named = surface(head + paint + one).stop;
  EXPECT_EQ(*named.cell_deg, (std::array{30.0, -90.0}));
  EXPECT_TRUE(has(refusal(head + paint + most + "cell_deg = [30, 0]\n"), "at most one"));
  EXPECT_TRUE(has(refusal(head + paint + "[stop]\ncell_percentile = 90\n"), "but not how well"));
  EXPECT_TRUE(
      has(refusal(head + paint + "[stop]\ncell_relative_error = 0.03\ncell_deg = [95, 0]\n"),
          "no direction"));
}

TEST(SceneFile, RefusesWhatCannotBeWithItsLine) {
  EXPECT_TRUE(has(refusal(head + paint + dirt + "coverage = 0.93\n"), "find no more room"));
  EXPECT_TRUE(has(refusal(head + paint + dirt + "coverage = 0.93\n"), "scene.toml:10"));
  EXPECT_TRUE(
      has(refusal(head + paint + dirt + "coverage = 0.97\noverlap = true\n"), "up to 0.95"));
  EXPECT_TRUE(has(refusal(head + paint + "[film]\nthickness_um = 5\nn = 0.9\n"), "at least 1"));
  EXPECT_TRUE(has(refusal(head + "model = \"velvet\"\n"), "scene.toml:5"));
  EXPECT_TRUE(has(refusal(head + paint + "gloss = 1\n"), "not known here"));
  EXPECT_TRUE(
      has(refusal("[surface]\nperiod_um = 5\n[substrate]\n" + paint), "wavelengths_um is missing"));
  EXPECT_TRUE(has(refusal(head + "model = \"lambertian\"\nrho = [0.1]\n"), "2 wavelengths"));
  EXPECT_TRUE(has(refusal(head + paint +
                          "[[particles]]\nmaterial = \"snow\"\nradius_um = 20\n"
                          "coverage = 0.1\n"),
                  "unknown"));
  EXPECT_TRUE(has(refusal("[surface]\nwavelengths_um = 1.5\n[substrate]\nmodel = \"lambertian\"\n"
                          "rho = 0.1\n" +
                          dirt + "coverage = 0.1\n"),
                  "between 0.4 and 0.9"));
  EXPECT_TRUE(
      has(refusal("[surface]\nwavelengths_um = 0.5\ntheta_i_deg = 90\n[substrate]\n" + paint),
          "theta_i_deg = 90"));
  EXPECT_TRUE(has(refusal(head + paint + "[materials.spare]\nmodel = \"lambertian\"\nrho = 0.1\n"),
                  "nothing is made of"));
}

}  // namespace
}  // namespace umov::surface
