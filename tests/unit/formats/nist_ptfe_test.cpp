#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>
#include <sstream>

#include "host/errors/error.hpp"
#include "host/formats/atomic_file.hpp"
#include "host/formats/nist_ptfe.hpp"
#include "host/formats/scan_table.hpp"

namespace umov::formats {
namespace {

using ::testing::HasSubstr;

const std::string path = std::string(UMOV_TEST_DATA) + "/nist_ptfe/ptfe_532_633.csv";

const MuellerTable& ptfe() {
  static const MuellerTable table = read_nist_ptfe(path);
  return table;
}

double element(const std::array<double, 16>& m, int row, int column) {
  return m[static_cast<std::size_t>(4 * (row - 1) + column - 1)];
}

TEST(NistPtfe, HasTheGeometryOfThisProject) {
  const MuellerTable& t = ptfe();
  ASSERT_EQ(t.size(), 3345u);
  std::map<double, int> incidences;
  bool retro = false;
  int in_plane_forward = 0;
  for (std::size_t n = 0; n < t.size(); ++n) {
    ++incidences[t.theta_i_deg[n]];
    EXPECT_GE(t.theta_i_deg[n], 0);
    EXPECT_GT(t.phi_r_deg[n], -180);
    EXPECT_LT(t.phi_r_deg[n], 180);
    in_plane_forward += t.phi_r_deg[n] == 0 && t.theta_r_deg[n] > 0;
    if (t.theta_r_deg[n] < 0) {
      EXPECT_EQ(t.phi_r_deg[n], 0);
      retro = true;
    }
  }
  EXPECT_TRUE(retro);
  EXPECT_GE(in_plane_forward, 9 * 11);
  EXPECT_EQ(incidences.size(), 6u);
  EXPECT_EQ(incidences.count(0), 1u) << "0.001 deg of the table stands for 0";
}

TEST(NistPtfe, NormalIncidenceAndFortyFiveDegreesReflectAsTheStandardIsKnownTo) {
  // pi f at 0/45 is .9998 at 532 nm.
  double sum = 0;
  int count = 0;
  for (std::size_t n = 0; n < ptfe().size(); ++n)
    if (ptfe().wavelength_nm[n] == 532 && ptfe().theta_i_deg[n] == 0 &&
        std::abs(std::abs(ptfe().theta_r_deg[n]) - 45) < 3 && ptfe().phi_r_deg[n] == 0) {
      sum += std::numbers::pi * ptfe().mueller[n][0];
      ++count;
    }
  ASSERT_GT(count, 0);
  EXPECT_NEAR(sum / count, 0.9998, 0.02);
}

TEST(NistPtfe, ForwardIsWhereTheSurfaceShines) {
  // At 75 deg the first surface adds a forward lobe, and its reflection is s-polarised.
  double forward = 0, backward = 0, q = 0;
  for (std::size_t n = 0; n < ptfe().size(); ++n) {
    if (ptfe().wavelength_nm[n] != 633 || ptfe().theta_i_deg[n] != 75 || ptfe().phi_r_deg[n] != 0)
      continue;
    if (ptfe().theta_r_deg[n] > 60) {
      forward = ptfe().mueller[n][0];
      q = element(ptfe().mueller[n], 2, 1);
    }
    if (ptfe().theta_r_deg[n] < -60) backward = ptfe().mueller[n][0];
  }
  EXPECT_GT(forward, 1.5 * backward);
  EXPECT_GT(q, 0);
}

/// Mean violations of m12 = m21, m13 = m31, m23 = m32, which reciprocity and mirror symmetry of an
/// isotropic surface demand at theta_r = theta_i, with an exit basis turned by `turns` times phi_r
/// more and the signs of U on the two sides.
double reciprocity_violation(double turns, int sign_out, int sign_in) {
  double sum = 0;
  int count = 0;
  for (std::size_t n = 0; n < ptfe().size(); ++n) {
    const double theta_i = ptfe().theta_i_deg[n];
    if (theta_i < 25 || theta_i > 65 || std::abs(ptfe().theta_r_deg[n] - theta_i) > 5) continue;
    const auto& m = ptfe().mueller[n];
    const double twice = 2 * turns * ptfe().phi_r_deg[n] * std::numbers::pi / 180;
    const double c = std::cos(twice), s = std::sin(twice);
    std::array<std::array<double, 3>, 3> t{};
    for (int j = 1; j <= 3; ++j) {
      const double in = j == 3 ? sign_in : 1;
      t[0][static_cast<std::size_t>(j - 1)] = in * element(m, 1, j);
      t[1][static_cast<std::size_t>(j - 1)] = in * (c * element(m, 2, j) + s * element(m, 3, j));
      t[2][static_cast<std::size_t>(j - 1)] =
          sign_out * in * (-s * element(m, 2, j) + c * element(m, 3, j));
    }
    for (const auto& [i, j] : {std::pair{0u, 1u}, {0u, 2u}, {1u, 2u}}) {
      sum += std::pow(t[i][j] - t[j][i], 2);
      ++count;
    }
  }
  return std::sqrt(sum / count);
}

TEST(NistPtfe, ObeysReciprocityInThisConventionAndInNoOther) {
  const double here = reciprocity_violation(0, 1, 1);
  EXPECT_LT(here, 0.0035);
  for (const double turns : {-2.0, -1.0, 1.0})
    EXPECT_GT(reciprocity_violation(turns, 1, 1), 1.8 * here) << turns;
  EXPECT_GT(reciprocity_violation(0, -1, 1), 1.8 * here);
  EXPECT_GT(reciprocity_violation(0, 1, -1), 1.8 * here);
}

TEST(NistPtfe, AtNormalIncidenceTheExitPolarisationTurnsWithTheDetector) {
  // An isotropic surface: in {s, p} of the exit beam m21 does not depend on phi_r and m31 is zero;
  // m12, m13 go as cos and -sin of 2 phi_r because the incident basis stays.
  double mean21 = 0, mean31 = 0, cos12 = 0, sin13 = 0, variance21 = 0, sin31 = 0;
  int count = 0;
  for (std::size_t n = 0; n < ptfe().size(); ++n) {
    if (ptfe().theta_i_deg[n] != 0 || std::abs(ptfe().theta_r_deg[n]) < 50) continue;
    const double phi =
        (ptfe().phi_r_deg[n] + (ptfe().theta_r_deg[n] < 0 ? 180 : 0)) * std::numbers::pi / 180;
    const auto& m = ptfe().mueller[n];
    mean21 += element(m, 2, 1) / m[0];
    variance21 += std::pow(element(m, 2, 1) / m[0], 2);
    mean31 += element(m, 3, 1) / m[0];
    sin31 += 2 * element(m, 3, 1) / m[0] * std::sin(2 * phi);
    cos12 += 2 * element(m, 1, 2) / m[0] * std::cos(2 * phi);
    sin13 += 2 * element(m, 1, 3) / m[0] * std::sin(2 * phi);
    ++count;
  }
  mean21 /= count;
  EXPECT_GT(mean21, 0.006);
  EXPECT_LT(std::sqrt(variance21 / count - mean21 * mean21), 0.012);
  EXPECT_NEAR(mean31 / count, 0, 0.002);
  EXPECT_NEAR(sin31 / count, 0, 0.002);
  EXPECT_NEAR(cos12 / count, 0.0155, 0.003);
  EXPECT_NEAR(sin13 / count, -0.0155, 0.003);
}

TEST(NistPtfe, UncertaintiesAreThoseOfItsMirrorPairs) {
  double largest = 0, smallest = 1;
  for (std::size_t n = 0; n < ptfe().size(); ++n) {
    largest = std::max(largest, ptfe().m00_relative_u[n]);
    smallest = std::min(smallest, ptfe().m00_relative_u[n]);
    EXPECT_GT(ptfe().element_relative_u[n], 0.003);
    EXPECT_LT(ptfe().element_relative_u[n], 0.02);
  }
  EXPECT_NEAR(smallest, 0.006, 0.001) << "near the normal, the known reciprocity scatter";
  EXPECT_NEAR(largest, 0.0195, 0.003) << "at 80 deg";
}

TEST(NistPtfe, ContractsToTheStatesOfAnInstrument) {
  const BrdfTable brdf = to_brdf_table(ptfe(), standard_states());
  ASSERT_EQ(brdf.points.size(), 7 * ptfe().size());
  ASSERT_EQ(brdf.dolp.dolp.size(), ptfe().size());
  double largest_dolp = 0;
  for (std::size_t n = 0; n < ptfe().size(); ++n) {
    const double* f = &brdf.points.brdf_per_sr[7 * n];
    EXPECT_DOUBLE_EQ(f[0], ptfe().mueller[n][0]);
    EXPECT_NEAR(f[1] + f[2], f[3], 1e-12) << "P analysed as P and S adds up to U";
    EXPECT_NEAR(f[4] + f[5], f[6], 1e-12);
    EXPECT_NEAR((f[3] + f[6]) / 2, f[0], 1e-12) << "P and S incident average to unpolarised";
    for (int i = 0; i < 7; ++i) EXPECT_GT(f[i], 0);
    EXPECT_NEAR(brdf.dolp.dolp[n], (f[1] - f[2]) / f[3], 1e-12);
    const auto& m = ptfe().mueller[n];
    largest_dolp = std::max(largest_dolp, std::hypot(m[4], m[8]) / m[0]);
  }
  EXPECT_GT(largest_dolp, 0.05) << "a real white standard does polarise";
  EXPECT_LT(largest_dolp, 0.129) << "the largest of all wavelengths and elements";
}

TEST(Contraction, FollowsTheStokesVectorsOfPolariserAndAnalyser) {
  std::array<double, 16> m{};
  m[0] = m[5] = 1;  // keeps Q
  m[10] = 0.5;      // half of U
  EXPECT_DOUBLE_EQ(contract(m, {0, 0}), 1);
  EXPECT_DOUBLE_EQ(contract(m, {0, 90}), 0);
  EXPECT_DOUBLE_EQ(contract(m, {45, 45}), 0.75);
  EXPECT_DOUBLE_EQ(contract(m, {45, -45}), 0.25);
  EXPECT_DOUBLE_EQ(contract(m, {open_axis, 30}), 0.5);
  EXPECT_DOUBLE_EQ(contract(m, {open_axis, open_axis}), 1);
}

TEST(NistPtfe, BadLinesAreRefusedWithLineAndColumn) {
  const std::string whole = read_whole_file(path);
  const std::string start = whole.substr(0, whole.find('\n', whole.find('\n') + 1) + 1);
  const auto refusal = [](const std::string& text) -> std::string {
    std::istringstream in(text);
    try {
      read_nist_ptfe(in, "ptfe");
    } catch (const Error& error) {
      return error.what();
    }
    return {};
  };
  EXPECT_EQ(refusal(start), "");
  std::string bad = start;
  EXPECT_THAT(refusal(bad.replace(bad.rfind("-0.001"), 6, "12.5")), HasSubstr("ptfe:2:thetai"));
  bad = start;
  EXPECT_THAT(refusal(bad.replace(bad.rfind("2.65E-01"), 8, "nan")), HasSubstr("ptfe:2:f_r11"));
  bad = start;
  EXPECT_THAT(refusal(bad.replace(bad.find("thetai"), 6, "theta")), HasSubstr("ptfe:1:thetai"));
  EXPECT_THAT(refusal(start.substr(0, start.size() - 20)), HasSubstr("fields"));
  EXPECT_THAT(refusal(""), HasSubstr("header line"));
}

}  // namespace
}  // namespace umov::formats
