// Angles as the lobes show them: a shifted scan is put right again.
#include <gtest/gtest.h>

#include <cmath>

#include "host/cli/study/alignment.hpp"

namespace umov::study {
namespace {

TEST(Alignment, IsReadFromTheDoubtsOfAFit) {
  formats::FitResult fit;
  fit.factors = {
      {"gain 532 nm", 3.0, 1.0}, {"detector zero", -0.5, 0.1}, {"incidence zero", 2.0, 0.1}};
  const auto found = alignment_found(fit, 0.1, 0.2);
  EXPECT_DOUBLE_EQ(found.theta_i_deg, 0.2);
  EXPECT_DOUBLE_EQ(found.theta_r_deg, -0.1);
  fit.factors.clear();
  EXPECT_EQ(alignment_found(fit, 0.1, 0.2).theta_i_deg, 0);
}

TEST(Alignment, GivesThePointsTheirTrueAnglesAndCosines) {
  // The detector stands at 60.5 deg instead of 60: f cos(60.5) is measured and divided by cos(60).
  const double f = 0.2, rad = std::acos(-1.0) / 180;
  formats::BrdfTable table;
  auto& p = table.points;
  for (const double phi : {0.0, 90.0}) {
    p.theta_i_deg.push_back(30);
    p.theta_r_deg.push_back(60);
    p.phi_r_deg.push_back(phi);
    p.brdf_per_sr.push_back(f * std::cos(60.5 * rad) / std::cos(60 * rad));
    p.brdf_u.push_back(0.01);
  }
  table.factors = {{"gain", {0.1, 0.1}}};
  const auto right = aligned(table, {0.25, 0.5});
  EXPECT_DOUBLE_EQ(right.points.theta_i_deg[0], 30.25);
  EXPECT_DOUBLE_EQ(right.points.theta_r_deg[0], 60.5);
  EXPECT_NEAR(right.points.brdf_per_sr[0], f, 1e-12);
  EXPECT_NEAR(right.points.brdf_u[0] / 0.01, right.factors[0].per_point[0] / 0.1, 1e-12);
  EXPECT_EQ(right.points.theta_r_deg[1], 60) << "out of plane nothing is known of it";
  EXPECT_EQ(right.points.brdf_per_sr[1], table.points.brdf_per_sr[1]);
}

}  // namespace
}  // namespace umov::study
