#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "host/errors/error.hpp"
#include "host/formats/astm.hpp"
#include "host/formats/scan_table.hpp"

namespace umov::formats {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

BrdfTable measured() {
  BrdfTable table;
  table.keys = {{"sample", "red gloss"},
                {"role", "sample"},
                {"Odd key with blanks", "kept: all"},
                {"wavelength", "reserved"}};
  auto& p = table.points;
  p.theta_i_deg = {30, 30, 30, 45.5};
  p.theta_r_deg = {30, -80, 25, 0};
  p.phi_r_deg = {0, 0, 147.857, 0};
  p.wavelength_nm = {532, 632.8, 814, 532};
  p.polarizer_deg = {open_axis, 0, 90, 45};
  p.analyzer_deg = {open_axis, 90, 0, -45};
  p.brdf_per_sr = {0.123456789012345, 0.02, -1e-7, 0.3};
  p.brdf_u = {0.001, 0.0002, 1e-6, 0.003};
  p.used = {1, 1, 0, 1};
  table.factors = {{"gain 532 nm", {0.1, 0, 0, 0.1}}};
  return table;
}

void expect_same(double a, double b) {
  if (std::isnan(a)) {
    EXPECT_TRUE(std::isnan(b));
  } else {
    EXPECT_EQ(a, b);
  }
}

TEST(Astm, PointsComeBackAsTheyWere) {
  const BrdfTable table = measured();
  TableWriting writing;
  writing.program = "umov test";
  const std::string text = write_astm(table, writing);
  EXPECT_TRUE(is_astm(text));
  EXPECT_THAT(text, AllOf(HasSubstr("not multiplied by cos theta"),
                          HasSubstr("phi_s - phi_i = 180"), HasSubstr("gain 532 nm"),
                          HasSubstr("NUM_POINTS 4"), HasSubstr("SAMPLE red gloss")));
  const BrdfTable back = read_astm(text, "red.astm");
  ASSERT_EQ(back.points.size(), 4u);
  for (std::size_t n = 0; n < 4; ++n) {
    EXPECT_EQ(back.points.theta_i_deg[n], table.points.theta_i_deg[n]);
    EXPECT_EQ(back.points.theta_r_deg[n], table.points.theta_r_deg[n]);
    EXPECT_EQ(back.points.phi_r_deg[n], table.points.phi_r_deg[n]);
    EXPECT_EQ(back.points.wavelength_nm[n], table.points.wavelength_nm[n]);
    expect_same(table.points.polarizer_deg[n], back.points.polarizer_deg[n]);
    expect_same(table.points.analyzer_deg[n], back.points.analyzer_deg[n]);
    EXPECT_EQ(back.points.brdf_per_sr[n], table.points.brdf_per_sr[n]);
    EXPECT_EQ(back.points.brdf_u[n], table.points.brdf_u[n]);
    EXPECT_EQ(back.points.used[n], table.points.used[n]);
  }
  const auto data = [](const std::string& t) { return t.substr(t.find("ANGLE_UNITS")); };
  EXPECT_EQ(data(write_astm(back, writing)), data(text));
  EXPECT_EQ(back.keys.size(), table.keys.size());
  for (const auto& key : table.keys) EXPECT_THAT(back.keys, ::testing::Contains(key));
}

TEST(Astm, RadiansAndSpectralColumnsAsInCornellFilesAreRead) {
  const BrdfTable t = read_astm(
      "NUM_POINTS 2\n"
      "ANGLE_UNITS RADIANS\n"
      "VARS theta_i,phi_i,theta_s,phi_s,450nm,650nm\n"
      "0.523599,0,0.523599,3.141593,0.2,0.5\n"
      "0.523599,0,0.349066,0.0,0.02,0.05\n",
      "x");
  ASSERT_EQ(t.points.size(), 4u);
  EXPECT_EQ(t.points.theta_i_deg[0], 30);
  EXPECT_EQ(t.points.theta_r_deg[0], 30);
  EXPECT_EQ(t.points.phi_r_deg[0], 0) << "phi_s - phi_i = 180 deg is the mirror direction";
  EXPECT_EQ(t.points.theta_r_deg[2], -20) << "phi_s = phi_i is the retro side";
  EXPECT_EQ(t.points.wavelength_nm[1], 650);
  EXPECT_EQ(t.points.brdf_per_sr[1], 0.5);
  EXPECT_DOUBLE_EQ(t.points.brdf_u[1], 0.025) << "5 % where the file states nothing";
  EXPECT_THAT(t.keys.back().second, HasSubstr("assumed"));
}

TEST(Astm, AssumedUncertaintiesDoNotVanishWithTheValue) {
  const std::string head =
      "ASTM E2387\nWAVELENGTH 633 nm\nANGLE_UNITS DEGREES\nVARS theta_i,theta_s,BRDF\n";
  const auto noisy =
      read_astm(head + "30,30,2\n30,40,0\n30,50,-0.001\n30,60,-0.0004\n", "x").points;
  EXPECT_NEAR(noisy.brdf_u[0], std::hypot(0.1, 0.001), 1e-12);
  for (const std::size_t n : {1u, 2u, 3u}) {
    EXPECT_NEAR(noisy.brdf_u[n], 0.001, 1e-5) << "what lies below zero is noise";
    EXPECT_EQ(noisy.used[n], 1);
  }
  const auto clipped = read_astm(head + "30,30,2\n30,40,0.003\n30,50,0\n", "x").points;
  EXPECT_EQ(clipped.brdf_u[2], 0.003) << "a zero is as uncertain as the smallest value";
  const auto dark = read_astm(head + "30,30,0\n", "x").points;
  EXPECT_EQ(dark.used[0], 0) << "nothing tells how uncertain it is";
}

TEST(Astm, AStatedUncertaintyOfZeroCannotBeWeighed) {
  const auto p = read_astm(
                     "ASTM E2387\nWAVELENGTH 633 nm\nANGLE_UNITS DEGREES\n"
                     "RELATIVE_UNCERTAINTY 0.02\nVARS theta_i,theta_s,BRDF\n30,30,1\n30,40,0\n",
                     "x")
                     .points;
  EXPECT_EQ(p.brdf_u[0], 0.02);
  EXPECT_EQ(p.used[0], 1);
  EXPECT_EQ(p.used[1], 0);
}

TEST(Astm, InPlaneBlocksOfAnInstrumentAreRead) {
  // Cosine-corrected, several angles of incidence, the sign of theta_s tells the side.
  const BrdfTable t = read_astm(
      "ASTM E1392-96\n"
      "OPERATOR someone\n"
      "WAVELENGTH 0.6328 um\n"
      "POLARIZATION_I S\n"
      "RELATIVE_UNCERTAINTY 0.02\n"
      "THETA_I 5\n"
      "NUM_POINTS 2\n"
      "VARS theta_s,CCBRDF\n"
      "60,0.1\n"
      "-60,0.05\n"
      "THETA_I 45\n"
      "NUM_POINTS 1\n"
      "VARS theta_s,CCBRDF\n"
      "0,0.2\n",
      "x");
  ASSERT_EQ(t.points.size(), 3u);
  EXPECT_NEAR(t.points.brdf_per_sr[0], 0.2, 1e-12) << "BRDF cos 60 deg = .1";
  EXPECT_NEAR(t.points.brdf_u[0], 0.004, 1e-12);
  EXPECT_EQ(t.points.theta_r_deg[1], -60);
  EXPECT_EQ(t.points.theta_i_deg[2], 45);
  EXPECT_EQ(t.points.wavelength_nm[0], 632.8);
  EXPECT_EQ(t.points.polarizer_deg[0], 90);
  EXPECT_TRUE(is_open(t.points.analyzer_deg[0]));
  EXPECT_EQ(t.keys.front().first, "operator");
}

TEST(Astm, TheHeaderSettlesWhereTheAzimuthBegins) {
  const std::string columns = "ANGLE_UNITS DEGREES\nWAVELENGTH 550 nm\nNUM_POINTS 1\n";
  const std::string row = "\n30,0,40,30,0.1\n";
  const auto phi = [](const std::string& text) {
    return read_astm("ASTM E2387\n" + text, "x").points.phi_r_deg.at(0);
  };
  EXPECT_EQ(phi(columns + "VARS theta_i,phi_i,theta_s,phi_s,BRDF" + row), -150);
  EXPECT_EQ(phi(columns + "SPECULAR_AZIMUTH 0\nVARS theta_i,phi_i,theta_s,phi_s,BRDF" + row), 30);
  EXPECT_EQ(phi(columns + "VARS theta_i,theta_s,phi_s,BRDF\n30,40,30,0.1\n"), 30)
      << "without an incident azimuth the scatter azimuth counts from the forward direction";
}

TEST(Astm, BadFilesAreRefusedWithLineAndColumn) {
  const std::string good = write_astm(measured(), {});
  const auto refusal = [](const std::string& text) -> std::string {
    try {
      read_astm(text, "x.astm");
    } catch (const Error& error) {
      return error.what();
    }
    return {};
  };
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
  };
  const auto first = std::to_string(
      2 + std::count(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(good.find("VARS")),
                     '\n'));
  EXPECT_EQ(refusal(good), "");
  EXPECT_THAT(refusal(with("0.123456789012345", "nan")), HasSubstr("x.astm:" + first + ":BRDF"));
  EXPECT_THAT(refusal(with("0.123456789012345,", "")), HasSubstr("9 fields, not 10"));
  EXPECT_THAT(refusal(with("30,180,30", "95,180,30")),
              AllOf(HasSubstr(first), HasSubstr("THETA_I")));
  EXPECT_THAT(refusal(with("30,180,30", "30,180,95")),
              AllOf(HasSubstr(first), HasSubstr("THETA_S")));
  EXPECT_THAT(refusal(with("30,180,30,0", "30,180,30,900")), HasSubstr("PHI_S"));
  EXPECT_THAT(refusal(with("U,U", "U,Q")), HasSubstr("no polarisation"));
  EXPECT_THAT(refusal(with("NUM_POINTS 4", "NUM_POINTS 5")), HasSubstr("4 points of 5"));
  EXPECT_THAT(refusal(with("NUM_POINTS 4", "NUM_POINTS 3")), HasSubstr("more than the 3"));
  EXPECT_THAT(refusal(with("NUM_POINTS 4", "NUM_POINTS 4000000000000000000")),
              HasSubstr("announced"));
  EXPECT_THAT(refusal(with("VARS", "WARS")), HasSubstr("before the line VARS"));
  EXPECT_THAT(refusal(with(",BRDF,", ",R,")), HasSubstr("colour channels"));
  EXPECT_THAT(refusal(with(",BRDF,", ",glow,")), HasSubstr("unknown column `glow`"));
  EXPECT_THAT(refusal(with("532,U,U", "5e9,U,U")), HasSubstr("WAVELENGTH"));
  EXPECT_THAT(refusal("ASTM E2387\nWAVELENGTH 633\nTHETA_I 5\nVARS theta_s,BRDF\n60,1\n"),
              HasSubstr("with unit"));
  EXPECT_THAT(refusal("ASTM E2387\nTHETA_I 5\nVARS theta_s,BRDF\n60,1\n"),
              HasSubstr("wavelength is not given"));
  EXPECT_THAT(refusal("ASTM E2387\nWAVELENGTH 633 nm\nVARS theta_s,BRDF\n60,1\n"),
              HasSubstr("angle of incidence"));
  EXPECT_THAT(refusal("ASTM E2387\nWAVELENGTH 633 nm\nVARS theta_i,theta_s,BRDF\n1,1,1\n"),
              HasSubstr("ANGLE_UNITS"))
      << "one degree or one radian?";
  EXPECT_THAT(refusal(""), HasSubstr("no points"));
  EXPECT_THAT(refusal("ASTM E2387\n"), HasSubstr("no line VARS"));
}

}  // namespace
}  // namespace umov::formats
