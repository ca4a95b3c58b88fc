#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "host/errors/error.hpp"
#include "host/formats/atomic_file.hpp"
#include "host/formats/cornell_brdf.hpp"
#include "host/formats/scan_table.hpp"
#include "tests/unit/optional_data.hpp"

namespace umov::formats {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

// Made for this test: incidence 40 and 80 deg, two wavelengths, forward and retro and out of plane,
// with values at grazing incidence that noise drove to zero.
const std::string small =
    "# A laboratory\n"
    "# Blue paint\n"
    "\n"
    "# num wls\n"
    "2\n"
    "# wls\n"
    "450\n"
    "650\n"
    "# theta i, phi i, theta s, phi_s, spectral sample values\n"
    "0.698132 0.000000 0.698132 3.141593 0.500 0.400\n"
    "0.698132 0.000000 0.698132 0.000000 0.050 0.020\n"
    "0.698132 0.000000 0.349066 -1.570796 0.052 0.021\n"
    "0.698132 0.000000 0.000000 0.000000 0.053 0.022\n"
    "1.396263 0.000000 0.100000 0.1 0.05 0.0\n"
    "1.396263 0.000000 0.200000 0.2 0.05 0.0\n"
    "1.396263 0.000000 0.300000 0.3 0.05 0.0\n"
    "1.396263 0.000000 0.400000 0.4 0.05 0.0\n"
    "1.396263 0.000000 0.500000 0.5 0.05 0.0\n"
    "1.396263 0.000000 0.100000 -0.1 0.05 0.002\n"
    "1.396263 0.000000 0.200000 -0.2 0.05 0.002\n"
    "1.396263 0.000000 0.300000 -0.3 0.05 0.002\n"
    "1.396263 0.000000 0.400000 -0.4 0.05 0.002\n"
    "1.396263 0.000000 0.500000 -0.5 0.05 0.002\n";

TEST(CornellBrdf, TheMirrorDirectionIsForwardHere) {
  ASSERT_TRUE(is_cornell_brdf(small));
  const BrdfTable table = read_cornell_brdf(small, "blue.brdf");
  const auto& p = table.points;
  ASSERT_EQ(p.size(), 2 * 14u);
  EXPECT_EQ(p.theta_i_deg[0], 40);
  EXPECT_EQ(p.theta_r_deg[0], 40);
  EXPECT_EQ(p.phi_r_deg[0], 0);
  EXPECT_EQ(p.brdf_per_sr[0], 0.5);
  EXPECT_EQ(p.wavelength_nm[1], 650);
  EXPECT_EQ(p.brdf_per_sr[1], 0.4);
  EXPECT_EQ(p.theta_r_deg[2], -40) << "back towards the source";
  EXPECT_EQ(p.phi_r_deg[2], 0);
  EXPECT_EQ(p.theta_r_deg[4], 20);
  EXPECT_EQ(p.phi_r_deg[4], 90) << "-90 deg from the source is +90 deg from the mirror direction";
  EXPECT_EQ(p.theta_r_deg[6], 0);
  EXPECT_FALSE(std::signbit(p.theta_r_deg[6]));
  EXPECT_TRUE(is_open(p.polarizer_deg[0]) && is_open(p.analyzer_deg[0]));
  EXPECT_THAT(table.keys[0].second, AllOf(HasSubstr("A laboratory"), HasSubstr("Blue paint")));
}

TEST(CornellBrdf, ClippedZerosSetTheNoiseFloorAndAreNotUsed) {
  const BrdfTable table = read_cornell_brdf(small, "blue.brdf");
  const auto& p = table.points;
  for (std::size_t n = 0; n < p.size(); ++n) EXPECT_EQ(p.used[n], p.brdf_per_sr[n] > 0 ? 1 : 0);
  // Five values of 650 nm are zero, the five smallest others are .002 at 80 deg.
  const double floor = 0.002 * std::cos(1.396263);
  EXPECT_NEAR(p.brdf_u[1], std::hypot(0.025 * 0.4, floor / std::cos(0.698132)), 1e-9);
  EXPECT_NEAR(p.brdf_u[9], 0.002, 1e-9) << "a zero at 80 deg is uncertain by the floor alone";
  // 450 nm has no zeros of its own and takes the other wavelength's floor.
  EXPECT_NEAR(p.brdf_u[0], std::hypot(0.025 * 0.5, floor / std::cos(0.698132)), 1e-9);
}

TEST(CornellBrdf, BadFilesAreRefusedWithTheLine) {
  const auto refusal = [](const std::string& text) -> std::string {
    try {
      read_cornell_brdf(text, "x.brdf");
    } catch (const Error& error) {
      return error.what();
    }
    return {};
  };
  const auto with = [](const std::string& from, const std::string& to) {
    std::string text = small;
    return text.replace(text.find(from), from.size(), to);
  };
  EXPECT_EQ(refusal(small), "");
  EXPECT_THAT(refusal(with("0.500 0.400", "0.500 nan")), HasSubstr("x.brdf:10:brdf"));
  EXPECT_THAT(refusal(with("0.500 0.400", "0.500")),
              AllOf(HasSubstr("x.brdf:10"), HasSubstr("5 numbers, not 6")));
  EXPECT_THAT(refusal(with("0.500 0.400", "0.500 -0.4")), HasSubstr("x.brdf:10:brdf"));
  EXPECT_THAT(refusal(with("0.698132 0.000000 0.698132", "40 0 40")),
              HasSubstr("x.brdf:10:theta_i"));
  EXPECT_THAT(refusal(with("\n2\n", "\n2000000000\n")), HasSubstr("x.brdf:5"));
  EXPECT_THAT(refusal(with("\n2\n", "\n3\n")), HasSubstr("wavelength"));
  EXPECT_THAT(refusal(with("\n2\n", "\n1\n")), HasSubstr("numbers, not 5"));
  EXPECT_THAT(refusal(with("450\n650", "650\n450")), HasSubstr("ascend"));
  EXPECT_THAT(refusal(with("3.141593", "9.9")), HasSubstr("x.brdf:10:phi_s"));
  EXPECT_THAT(refusal(small + "0.698132 0.000000 0.698132 0.000000 0.050 0.020\n"),
              HasSubstr("twice"));
  EXPECT_THAT(refusal("# a\n2\n400\n"), HasSubstr("wavelengths are not complete"));
  EXPECT_THAT(refusal("# a\n1\n400\n"), HasSubstr("no records"));
  EXPECT_THAT(refusal(""), HasSubstr("no numbers"));
  EXPECT_FALSE(is_cornell_brdf("index,time_s\n"));
}

TEST(CornellBrdf, TheDistributedPaintsAreWhatIsKnownOfThem) {
  const auto path = umov::testing::optional_data("cornell_paint/garnet_red.brdf");
  if (!path) GTEST_SKIP() << "no cornell_paint/garnet_red.brdf: name its folder in UMOV_DATA";
  const BrdfTable table = read_cornell_brdf(read_whole_file(*path), path->string());
  const auto& p = table.points;
  ASSERT_EQ(p.size(), 1439u * 31u);
  std::size_t in_plane = 0, unused = 0;
  double forward = 0, backward = 0;
  for (std::size_t n = 0; n < p.size(); ++n) {
    in_plane += p.phi_r_deg[n] == 0 && p.wavelength_nm[n] == 650;
    unused += p.used[n] == 0;
    EXPECT_GT(p.brdf_u[n], 0);
    if (p.theta_i_deg[n] != 60 || p.wavelength_nm[n] != 650 || p.phi_r_deg[n] != 0) continue;
    if (p.theta_r_deg[n] > 0) forward = std::max(forward, p.brdf_per_sr[n]);
    if (p.theta_r_deg[n] < 0) backward = std::max(backward, p.brdf_per_sr[n]);
  }
  EXPECT_GE(in_plane, 125u);
  EXPECT_EQ(unused, 213u);
  EXPECT_GT(forward, 10 * backward) << "a medium-gloss paint shines forward";
}

}  // namespace
}  // namespace umov::formats
