// Materials of the cases.
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "hil/blind/material.hpp"
#include "hil/plant/plant_config.hpp"
#include "hil/plant/rough_surface.hpp"

namespace umov::blind {
namespace {

TEST(Materials, OfEveryFamilyReflectLessThanTheyGet) {
  for (const std::string& family : material_families()) {
    for (std::uint64_t seed = 1; seed < 5; ++seed) {
      Random random(seed);
      const Material material = draw_material(random, family);
      const auto sample = material.sample();
      for (const double ti : {0.0, 45.0}) {
        const double value = plant::dhr(*sample, ti, 633).unpolarized;
        EXPECT_GT(value, 0.005) << family << "\n" << material.toml();
        EXPECT_LT(value, 1.0) << family << "\n" << material.toml();
      }
      EXPECT_GT(sample->slope_rms(), 0.03) << family;
    }
  }
}

TEST(Materials, SayTruthfullyWhetherTheyAreOneGaussianLobe) {
  for (const std::string& family : material_families()) {
    Random random(8);
    const Material material = draw_material(random, family);
    EXPECT_EQ(material.one_gaussian_lobe, family == "gaussian_facets");
    if (!material.one_gaussian_lobe) continue;
    std::map<std::string, std::vector<double>> number;
    for (const auto& [key, values] : material.numbers) number[key] = values;
    const auto sample = material.sample();
    const auto in = optics::incident_beam(optics::radians(50.0));
    const auto out = optics::exit_beam(optics::radians(30.0), 0.4);
    const double fresnel =
        optics::element(plant::facet_reflection(number["n"][0], 0.0, in, out), 0, 0);
    const double d1 = number["rho_d1"][1];
    const double d2 = number.contains("rho_d2") ? number["rho_d2"][1] : 0.0;
    const double cosines = std::cos(optics::radians(50.0)) * std::cos(optics::radians(30.0));
    EXPECT_NEAR(optics::element(sample->brdf(in, out, 633.0), 0, 0),
                fresnel * plant::facet_factor(number["slope"][0], in.k, out.k) + d1 + d2 / cosines,
                1e-12);
  }
}

TEST(Materials, AreMostlyOneGaussianLobeButOftenNot) {
  std::map<std::string, int> count;
  Random random(5);
  for (int i = 0; i < 600; ++i) ++count[draw_material(random).family];
  EXPECT_NEAR(count["gaussian_facets"], 360, 60);
  EXPECT_EQ(count.size(), material_families().size());
}

TEST(Materials, ArePerturbedOneValueAtATime) {
  Random random(2);
  const Material material = draw_material(random, "he_torrance");
  std::size_t values = 0;
  for (const auto& [key, list] : material.numbers) values += list.size();
  EXPECT_EQ(perturbed(material).size(), values);
  for (const Perturbed& p : perturbed(material)) EXPECT_NE(p.material.toml(), material.toml());
}

}  // namespace
}  // namespace umov::blind
