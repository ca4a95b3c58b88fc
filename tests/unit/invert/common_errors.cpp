// Errors that points share: which of them scale the model, and which add to it.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <set>

#include "host/invert/observations.hpp"

namespace umov::invert {
namespace {

constexpr double rad = std::numbers::pi / 180;

/// A noisy lobe on a diffuse ground, in steps of five degrees and of one about the lobe, as plans
/// have them; three states.
formats::BrdfTable uneven_scan(double noise) {
  formats::BrdfTable table;
  std::mt19937_64 random(11);
  std::normal_distribution<double> normal;
  std::set<double> angles;
  for (int theta_r = -80; theta_r <= 80; theta_r += 5) angles.insert(theta_r);
  for (int theta_r = 20; theta_r <= 40; ++theta_r) angles.insert(theta_r);
  auto& p = table.points;
  for (const double analyzer : {0.0, 45.0, 90.0})
    for (const double theta_r : angles) {
      const double f = 0.15 + 0.5 * std::exp(-std::pow((theta_r - 30) / 5, 2));
      p.theta_i_deg.push_back(30);
      p.theta_r_deg.push_back(theta_r);
      p.phi_r_deg.push_back(0);
      p.wavelength_nm.push_back(633);
      p.polarizer_deg.push_back(0);
      p.analyzer_deg.push_back(analyzer);
      p.brdf_per_sr.push_back(f * (1 + noise * normal(random)));
      p.brdf_u.push_back(noise * f);
      p.used.push_back(1);
    }
  return table;
}

/// Whether each of: a cosine's error, the same error on every point, a drive's stop in one place.
std::array<bool, 3> relative(formats::BrdfTable table) {
  formats::BrdfTable::Factor cosine{"cosine", {}}, pedestal{"pedestal", {}}, stop{"stop 30", {}};
  for (std::size_t i = 0; i < table.points.size(); ++i) {
    const double theta_r = table.points.theta_r_deg[i];
    cosine.per_point.push_back(table.points.brdf_per_sr[i] * 1e-3 * std::tan(theta_r * rad));
    pedestal.per_point.push_back(1e-3);
    stop.per_point.push_back(theta_r == 30 ? 1e-3 * table.points.brdf_per_sr[i] : 0.0);
  }
  table.factors = {cosine, pedestal, stop};
  const auto& common = observations(table, 0).spectra.at(0).common;
  return {common[0].relative, common[1].relative, common[2].relative};
}

TEST(CommonErrors, ThoseMadeOfTheNoisyValueScaleTheModelWhateverTheSteps) {
  for (const double noise : {0.003, 0.05, 0.2}) {
    const auto [cosine, pedestal, stop] = relative(uneven_scan(noise));
    EXPECT_TRUE(cosine) << noise;
    EXPECT_FALSE(pedestal) << noise;
    EXPECT_TRUE(stop) << noise;
  }
}

}  // namespace
}  // namespace umov::invert
