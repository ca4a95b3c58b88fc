#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <sstream>

#include "host/errors/error.hpp"
#include "host/formats/jsss_scan.hpp"
#include "host/formats/scan_table.hpp"

namespace umov::formats {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

const std::string folder = std::string(UMOV_TEST_DATA) + "/jsss_mwir/";

TEST(JsssScan, HoldsItsMaterials) {
  const JsssScan scan = read_jsss_scan(folder + "inplane.csv");
  EXPECT_EQ(scan.size(), 1780u);
  EXPECT_THAT(scan.materials(), ElementsAre("aluminium sandblasted", "reference lacquer smooth"));
}

TEST(JsssScan, DividedByTheCosineADiffuseMetalIsReciprocal) {
  const BrdfTable brdf =
      to_brdf_table(read_jsss_scan(folder + "inplane.csv"), "aluminium sandblasted", nullptr);
  ASSERT_EQ(brdf.points.size(), 890u);
  std::map<std::pair<double, double>, double> f;
  for (std::size_t n = 0; n < brdf.points.size(); ++n)
    f[{brdf.points.theta_i_deg[n], brdf.points.theta_r_deg[n]}] = brdf.points.brdf_per_sr[n];
  const std::vector<double> angles = {15, 20, 30, 40, 45, 50, 60, 70, 80};
  double sum = 0;
  int pairs = 0;
  for (const double a : angles)
    for (const double b : angles)
      if (a < b) {
        sum += std::abs(std::log(f.at({a, b}) / f.at({b, a})));
        ++pairs;
      }
  EXPECT_LT(sum / pairs, 0.03);
}

TEST(JsssScan, TheLacquerMirrorsWithinADegree) {
  const BrdfTable brdf =
      to_brdf_table(read_jsss_scan(folder + "inplane.csv"), "reference lacquer smooth", nullptr);
  for (const double theta_r_deg : {30.0, 45.0, 60.0}) {
    double peak = 0, at = 0;
    for (std::size_t n = 0; n < brdf.points.size(); ++n)
      if (brdf.points.theta_r_deg[n] == theta_r_deg && brdf.points.brdf_per_sr[n] > peak) {
        peak = brdf.points.brdf_per_sr[n];
        at = brdf.points.theta_i_deg[n];
      }
    EXPECT_NEAR(at, theta_r_deg, 1);
  }
}

TEST(JsssScan, RelativeUnitsAreFlaggedAndEmissivityGivesTheDhr) {
  const JsssEmissivity emissivity = read_jsss_emissivity(folder + "emissivity.csv");
  const BrdfTable brdf = to_brdf_table(read_jsss_scan(folder + "inplane.csv"),
                                       "reference lacquer smooth", &emissivity);
  EXPECT_EQ(brdf.keys[3], (std::pair<std::string, std::string>("relative_units", "1")));
  ASSERT_EQ(brdf.dhr.dhr.size(), 10u);
  EXPECT_EQ(brdf.dhr.theta_i_deg[0], 85);
  EXPECT_NEAR(brdf.dhr.dhr[0], 1 - 0.45235, 1e-12);
  int unused = 0;
  for (std::size_t n = 0; n < brdf.points.size(); ++n) {
    EXPECT_GT(brdf.points.brdf_u[n], 0);
    EXPECT_TRUE(is_open(brdf.points.polarizer_deg[n]));
    unused += brdf.points.used[n] == 0;
  }
  EXPECT_LT(unused, 300) << "only what lies in the noise is set aside";
}

TEST(JsssScan, UnknownMaterialsAndBadLinesAreNamed) {
  const JsssScan scan = read_jsss_scan(folder + "inplane.csv");
  try {
    to_brdf_table(scan, "gold", nullptr);
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("reference lacquer smooth"));
  }
  const std::string head = "material,theta_r_deg,theta_i_deg,radiance_w_m2_sr\n";
  for (const auto& [line, place] : std::vector<std::pair<std::string, std::string>>{
           {"x,15,89,wide\n", "j:2:radiance_w_m2_sr"},
           {"x,15,90,1\n", "j:2:theta_i_deg"},
           {"x,150,9,1\n", "j:2:theta_r_deg"},
           {",15,9,1\n", "j:2:material"},
           {"x,15,9\n", "j:2: the line has 3 fields"}}) {
    std::istringstream in(head + line);
    try {
      read_jsss_scan(in, "j");
      FAIL() << line;
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), HasSubstr(place));
    }
  }
}

}  // namespace
}  // namespace umov::formats
