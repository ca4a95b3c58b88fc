// Scene files: what they describe, and what they refuse.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "host/errors/error.hpp"
#include "host/surface/particles.hpp"
#include "host/surface/scene_file.hpp"
#include "host/trace/simulation.hpp"
#include "tests/unit/failure.hpp"

namespace umov::surface {
namespace {

const std::string head = "wavelengths_nm = [500, 700]\nperiod_um = 1000\n";
const std::string paint = "[ground]\nkind = \"lambertian\"\nalbedo = [0.04, 0.05]\n";

Surface surface(const std::string& text) {
  return surface_from_toml(text, "scene.toml", 1);
}

std::string refusal(const std::string& text) {
  return failure_of([&] { surface(text); });
}

TEST(Scatter, CoversWhatIsAskedWithoutOverlap) {
  std::vector<Disc> discs;
  scatter(discs, {40.0, 1.3}, 0.2, 1000.0, 3);
  const std::size_t first = discs.size();
  scatter(discs, {20.0}, 0.15, 1000.0, 4);
  double area = 0.0;
  for (std::size_t i = 0; i < discs.size(); ++i) {
    area += 3.14159265358979 * discs[i].radius * discs[i].radius;
    for (std::size_t j = 0; j < i; ++j) {
      const double dx = std::remainder(discs[i].x - discs[j].x, 1000.0);
      const double dy = std::remainder(discs[i].y - discs[j].y, 1000.0);
      ASSERT_GE(std::hypot(dx, dy), (discs[i].radius + discs[j].radius) * (1.0 - 1e-12));
    }
  }
  EXPECT_NEAR(area / 1e6, 0.35, 0.002);
  EXPECT_GT(discs.size(), first + 400);
  std::vector<Disc> crowd;
  EXPECT_THROW(scatter(crowd, {100.0}, 0.7, 1000.0, 5), Error);
}

TEST(SceneFile, DescribesDirtAndDropsOnPaint) {
  const Surface s = surface(head + paint +
                            "[[particles]]\nkind = \"soil\"\nalbedo = 0.3\ndiameter_um = 40\n"
                            "coverage = 0.2\n"
                            "[[particles]]\nkind = \"drop\"\ncontact_angle_deg = 15\n"
                            "index = \"H2O_Daimon-20.0C\"\ndiameter_um = 60\ncoverage = 0.1\n");
  ASSERT_EQ(s.layers.size(), 2u);
  EXPECT_NEAR(s.layers[0].coverage, 0.2, 0.001);
  EXPECT_NEAR(s.layers[1].coverage, 0.1, 0.002);
  EXPECT_EQ(s.scene.spheres.size(), s.layers[0].count + s.layers[1].count);
  const trace::Sphere& drop = s.scene.spheres.back();
  // A cap of 15° that is 60 µm wide is 30·tan(7.5°) high.
  EXPECT_NEAR(drop.centre.z + drop.radius, 30.0 * std::tan(0.5 * 15.0 / 57.29577951308232), 1e-9);
  EXPECT_EQ(drop.base_z, 0.0);
  EXPECT_NEAR(s.scene.media[1].n[0], 1.335, 0.003);
}

TEST(SceneFile, OfAModelOrRoughMetalCanBeTraced) {
  const Surface model = surface(head +
                                "[ground]\nkind = \"model\"\nmodel = \"microfacet+lambertian\"\n"
                                "set = { \"0.n\" = 1.5, \"1.rho\" = [0.1, 0.4] }\n");
  const Surface rough = surface(head +
                                "[ground]\nkind = \"conductor\"\nn = 1.2\nkappa = 7\n"
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

TEST(SceneFile, RefusesWhatCannotBeWithItsLine) {
  const std::string soil = "[[particles]]\nkind = \"soil\"\nalbedo = 0.3\ndiameter_um = 40\n";
  EXPECT_NE(refusal(head + paint + soil + "coverage = 0.8\n").find("find no more room"),
            std::string::npos);
  EXPECT_NE(refusal(head + paint + "[film]\nthickness_um = 5\nn = 0.9\n").find("at least 1"),
            std::string::npos);
  EXPECT_NE(refusal(head + "[ground]\nkind = \"velvet\"\n").find("scene.toml:4"),
            std::string::npos);
  EXPECT_NE(refusal(head + paint + "gloss = 1\n").find("not known here"), std::string::npos);
  EXPECT_NE(refusal("period_um = 5\n" + paint).find("wavelengths_nm is missing"),
            std::string::npos);
  EXPECT_NE(
      refusal(head + "[ground]\nkind = \"lambertian\"\nalbedo = [0.1]\n").find("2 wavelengths"),
      std::string::npos);
  EXPECT_NE(refusal(head + paint + soil + "coverage = 0.1\n[film]\nthickness_um = 5\nn = 1.3\n")
                .find("bare flat ground"),
            std::string::npos);
}

}  // namespace
}  // namespace umov::surface
