// The reproducibility of a bench, put to points: what they share, and what a steep slope makes of a
// drive's stop.
#include <gtest/gtest.h>

#include <cmath>

#include "host/cli/study/bench_doubts.hpp"

namespace umov::study {
namespace {

/// Two wavelengths and incidences; f = 1 + θr/10 per degree near the normal.
formats::BrdfTable ramp() {
  formats::BrdfTable table;
  auto& p = table.points;
  for (const double nm : {532.0, 633.0})
    for (const double theta_i : {10.0, 30.0})
      for (double theta_r = 0; theta_r <= 4; ++theta_r) {
        p.theta_i_deg.push_back(theta_i + 0.03);
        p.theta_r_deg.push_back(theta_r);
        p.phi_r_deg.push_back(0);
        p.wavelength_nm.push_back(nm);
        p.polarizer_deg.push_back(0);
        p.analyzer_deg.push_back(0);
        p.brdf_per_sr.push_back(1 + theta_r / 10);
        p.brdf_u.push_back(1e-6);
        p.used.push_back(1);
      }
  return table;
}

TEST(BenchDoubts, TheSourceIsCommonToAWavelengthAndToAnIncidence) {
  const auto table = with_bench_doubts(ramp(), {.source = 0.003, .position_deg = 0});
  ASSERT_EQ(table.factors.size(), 2u + 4u);
  for (const auto& factor : table.factors) {
    std::size_t touched = 0;
    for (std::size_t i = 0; i < factor.per_point.size(); ++i) {
      if (factor.per_point[i] == 0) continue;
      ++touched;
      EXPECT_NEAR(factor.per_point[i], 0.003 * table.points.brdf_per_sr[i], 1e-15);
    }
    EXPECT_EQ(touched, factor.name.find("θi") == std::string::npos ? 10u : 5u) << factor.name;
  }
  EXPECT_DOUBLE_EQ(table.points.brdf_u[0], 1e-6);
}

TEST(BenchDoubts, ADrivesStopMattersByTheSlope) {
  const auto table = with_bench_doubts(ramp(), {.source = 0, .position_deg = 0.01});
  // At the normal the cosine is flat: .1 per degree, two drives.
  EXPECT_NEAR(table.points.brdf_u[1], std::sqrt(2.0) * 0.01 * 0.1, 2e-5);
}

}  // namespace
}  // namespace umov::study
