// Energy in scenes that overlap, touch and are met by grazing light: what goes in is reflected,
// absorbed, or counted as lost.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "host/surface/scene_file.hpp"
#include "host/trace/simulation.hpp"

namespace umov::surface {
namespace {

using optics::radians;

trace::Result simulated(const std::string& text, double theta_i_deg, std::uint64_t samples,
                        bool emissivity = false) {
  const Surface s = surface_from_toml(text, "scene.toml", {});
  const trace::Geometry geometry(s.scene);
  const trace::PathTracer tracer(s.scene, geometry);
  trace::Request request;
  request.theta_i = radians(theta_i_deg);
  request.samples = samples;
  request.emissivity = emissivity;
  return trace::simulate(tracer, trace::Hemisphere(6, 0, 0.0), request);
}

const std::string head = "[surface]\nwavelengths_um = 0.55\n";
const std::string paint = "[substrate]\nmodel = \"lambertian\"\nrho = 0.5\n";
const std::string rough =
    "[substrate]\nmodel = \"lambertian\"\nrho = 0.5\n"
    "rough = { slope_rms = 0.4, correlation_um = 30 }\n";
const std::string dirt = "[[particles]]\nmaterial = \"dry_soil\"\nradius_um = 20\noverlap = true\n";
const std::string drops =
    "[[drops]]\nradius_um = 20\nn = 1.33\nkappa = 1e-5\noverlap = true\ncontact_angle_deg = ";
const std::string film = "[film]\nthickness_um = 15\nn = 1.45\n";

TEST(Balance, HoldsWhereThingsOverlapTouchAndAreGrazed) {
  const std::string scenes[] = {
      head + paint + drops + "180\ncoverage = 0.95\n",
      head + paint + drops + "90\ncoverage = 0.95\n",
      head + paint + drops + "20\ncoverage = 0.7\n" + dirt + "coverage = 0.5\n",
      head + paint + drops + "120\ncoverage = 0.5\n" + dirt + "coverage = 0.3\n" + film,
      head + paint + drops + "120\ncoverage = 0.5\n" + film + "particles = \"on\"\n",
      head + rough + drops + "180\ncoverage = 0.3\n" + dirt + "coverage = 0.3\n",
      head + rough + drops + "60\ncoverage = 0.5\n" + film,
  };
  for (const std::string& scene : scenes) {
    for (const double theta : {20.0, 89.0}) {
      const trace::Ledger l = simulated(scene, theta, 1 << 14).ledger();
      const double in = l.launched[0];
      EXPECT_NEAR((l.above[0] + l.absorbed[0]) / in, 1.0, 1e-3) << theta << "°\n" << scene;
      EXPECT_LE((l.lost[0] + l.below[0]) / in, 3e-5) << theta << "°\n" << scene;
      EXPECT_EQ(l.endless, 0u);
    }
  }
}

TEST(Overlap, OfDropsWithTheirOwnLiquidIsNotSeen) {
  // Drops below the surface of a film of the same water, and a film without them.
  const std::string wet = "[film]\nthickness_um = 45\nn = 1.33\n";
  const std::string hidden =
      "[[drops]]\nradius_um = 20\nn = 1.33\noverlap = true\ncontact_angle_deg = 180\n"
      "coverage = 0.5\n";
  const auto with = simulated(head + paint + hidden + wet, 50.0, 1 << 16).hemispherical(0);
  const auto without = simulated(head + paint + wet, 50.0, 1 << 16).hemispherical(0);
  EXPECT_NEAR(with.mean[0][0], without.mean[0][0],
              4.0 * std::hypot(with.error[0][0], without.error[0][0]));
  EXPECT_LT(with.error[0][0], 3e-3);
  // Of another liquid they are.
  std::string oil = hidden;
  oil.replace(oil.find("1.33"), 4, "1.80");
  const auto other = simulated(head + paint + oil + wet, 50.0, 1 << 16).hemispherical(0);
  EXPECT_GT(std::abs(other.mean[0][0] - without.mean[0][0]), 6.0 * other.error[0][0]);
}

TEST(Absorptance, IsTheRestOfTheReflectanceByEachMaterial) {
  const std::string scene = "[surface]\nwavelengths_um = [4.0]\nperiod_um = 1000\n" + paint +
                            drops +
                            "90\ncoverage = 0.3\n"
                            "[[particles]]\nmaterial = \"clay\"\nradius_um = 15\ncoverage = 0.3\n"
                            "[materials.clay]\nmodel = \"lambertian\"\nrho = 0.3\n";
  const trace::Result result = simulated(scene, 60.0, 1 << 17, true);
  const Surface s = surface_from_toml(scene, "scene.toml", {});
  double all = 0.0;
  double polarised = 0.0;
  for (std::size_t owner = 0; owner < s.scene.materials.size() + s.scene.media.size(); ++owner) {
    const auto a = result.absorptance(owner, 0);
    all += a[0].mean;
    polarised += a[1].mean;
    if (owner <= 1) {
      EXPECT_GT(a[0].mean, 0.05);
      EXPECT_LT(a[0].error, 0.005);
    }
  }
  EXPECT_NEAR(all, result.ledger().absorbed[0] / result.ledger().launched[0], 1e-9);
  EXPECT_NEAR(all + result.hemispherical(0).mean[0][0], 1.0, 1e-3);
  // What leaves less s than p is absorbed the other way round.
  EXPECT_NEAR(polarised, -optics::element(result.hemispherical(0).mean, 0, 1), 2e-3);
}

}  // namespace
}  // namespace umov::surface
