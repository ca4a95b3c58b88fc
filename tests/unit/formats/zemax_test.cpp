#include "host/formats/zemax_bsdf.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <regex>

#include "host/brdf/dhr.hpp"
#include "host/formats/table_h5.hpp"
#include "table_sources.hpp"

namespace umov::formats {
namespace {

using testing::expect_refused;
using testing::m00;
using testing::satin;

/// Two incidences, three azimuths, four radial angles; the BRDF is 100 θi-number + 10
/// azimuth-number
/// + radial-number.
const std::string by_hand =
    "# a comment\n"
    "Source  Measured\n"
    "Symmetry  PlaneSymmetrical\n"
    "SpectralContent  Monochrome\n"
    "ScatterType  BRDF\n"
    "SampleRotation  1\n"
    "0\n"
    "AngleOfIncidence  2\n"
    "30 50\n"
    "ScatterAzimuth 3\n"
    "0 90 180\n"
    "ScatterRadial 4\n"
    "0\t10  20 40\n"
    "\n"
    "Monochrome\n"
    "DataBegin\n"
    "TIS 0.5\n"
    "111 112 113 114\n"
    "121 122 123 124\n"
    "131 132 133 134\n"
    "TIS 0.6\n"
    "211 212 213 214\n"
    "221 222 223 224\n"
    "231 232 233 234\n"
    "DataEnd\n";

TablePtr read(const std::string& text) {
  return read_zemax(text, "x.bsdf");
}

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  const auto at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return text.replace(at, what.size(), by);
}

std::string without_comments(const std::string& text) {
  return std::regex_replace(text, std::regex("#[^\n]*\n"), "");
}

TEST(Zemax, CountsRadialAnglesFromTheMirrorDirectionAndAzimuthFromTheNormal) {
  const TablePtr table = read(by_hand);
  EXPECT_NEAR(m00(*table, 0.55, 30, 30, 0), 121, 10.001);  // mirror direction: any azimuth
  EXPECT_NEAR(m00(*table, 0.55, 30, 10, 0), 113, 1e-6);    // azimuth 0, towards the normal
  EXPECT_NEAR(m00(*table, 0.55, 30, -10, 0), 114, 1e-6);   // past the normal, retro side
  EXPECT_NEAR(m00(*table, 0.55, 30, 50, 0), 133, 1e-6);    // azimuth 180, towards the horizon
  // 20 degrees across the plane of incidence: cos θr = cos 30 cos 20.
  const double theta_r =
      optics::degrees(std::acos(std::cos(optics::radians(30.0)) * std::cos(optics::radians(20.0))));
  const double phi = optics::degrees(
      std::asin(std::sin(optics::radians(20.0)) / std::sin(optics::radians(theta_r))));
  EXPECT_NEAR(m00(*table, 0.55, 30, theta_r, phi), 123, 1e-6);
  EXPECT_NEAR(m00(*table, 0.55, 30, theta_r, -phi), 123, 1e-6);
  EXPECT_NEAR(m00(*table, 0.55, 50, 40, 0), 212, 1e-6);
  // Between incidences at the same radial angle and azimuth; outside them the nearest.
  EXPECT_NEAR(m00(*table, 0.55, 40, 30, 0), 162, 1e-6);
  EXPECT_NEAR(m00(*table, 0.55, 20, 10, 0), 112, 1e-6);
  EXPECT_EQ(m00(*table, 0.55, 30, 90.5, 0), 0.0);
}

TEST(Zemax, ComesBackNumberByNumber) {
  const std::string once = write_zemax(*read(by_hand), {});
  EXPECT_EQ(write_zemax(*read(once), {}), once);
  const std::string through_h5 =
      write_zemax(*read_table_h5(write_table_h5(*read(by_hand), {}), "t.h5"), {});
  EXPECT_EQ(without_comments(through_h5), without_comments(once));
  const auto a = std::dynamic_pointer_cast<const SpecularTable>(read(by_hand));
  const auto b = std::dynamic_pointer_cast<const SpecularTable>(read(once));
  EXPECT_TRUE(std::equal(a->values().begin(), a->values().end(), b->values().begin()));
  EXPECT_TRUE(std::equal(a->tis().begin(), a->tis().end(), b->tis().begin()));
}

TEST(Zemax, GivesASatinPaintBackWithinItsGrid) {
  const auto source = satin();
  const TablePtr table = read(write_zemax(source, {}));
  EXPECT_NEAR(table->wavelengths_um().front(), 0.55, 1e-12);
  const auto difference = compare_tables(*table, source, {0.55});
  EXPECT_LT(difference.median, 2e-3);
  EXPECT_LT(difference.p95, 0.012);
}

TEST(Zemax, TotalsAreTheDirectionalHemisphericalReflectance) {
  const auto source = satin();
  const auto table = std::dynamic_pointer_cast<const SpecularTable>(read(write_zemax(source, {})));
  for (const std::size_t i : {0u, 6u, 12u, 15u}) {
    const double theta_i = optics::radians(table->axes().theta_i_deg[i]);
    const double dhr = brdf::dhr(source.model(), source.values(0), 0.55, theta_i).unpolarized;
    EXPECT_NEAR(table->tis()[i], dhr, 1e-3 * dhr) << table->axes().theta_i_deg[i];
  }
}

TEST(Zemax, KeepsTheWavelengthInAComment) {
  TableWriting writing;
  writing.wavelengths_um = {0.6328};
  const std::string text = write_zemax(testing::model_table("lambertian"), writing);
  EXPECT_THAT(text, ::testing::HasSubstr("# wavelength: 632.8 nm"));
  EXPECT_THAT(text, ::testing::HasSubstr("not multiplied by cos theta"));
  EXPECT_NEAR(read(text)->wavelengths_um().front(), 0.6328, 1e-12);
  EXPECT_EQ(read(by_hand)->wavelengths_um().front(), zemax_unnamed_um);
}

TEST(Zemax, HoldsOneWavelength) {
  const auto two = testing::model_table("lambertian", {}, {0.5, 0.6});
  expect_refused([&] { write_zemax(two, {}); }, {"one wavelength", "--wavelength-nm", "500, 600"});
}

TEST(Zemax, ReadsTristimulusBlocks) {
  std::string text = replaced(by_hand, "SpectralContent  Monochrome", "SpectralContent  XYZ");
  const auto at = text.find("Monochrome\nDataBegin");
  const std::string block = text.substr(at + std::string("Monochrome").size());
  text = text.substr(0, at) + "TristimulusX" + block + "TristimulusY" +
         replaced(block, "113", "999") + "TristimulusZ" + block;
  const TablePtr table = read(text);
  ASSERT_EQ(table->wavelengths_um().size(), 3u);
  EXPECT_NEAR(m00(*table, zemax_tristimulus_um[1], 30, 10, 0), 999, 1e-6);
  EXPECT_NEAR(m00(*table, zemax_tristimulus_um[0], 30, 10, 0), 113, 1e-6);
  const std::string once = write_zemax(*table, {});
  EXPECT_EQ(write_zemax(*read(once), {}), once);
}

TEST(Zemax, TellsLeftFromRightWhereTheFileDoes) {
  const std::string text =
      replaced(replaced(by_hand, "PlaneSymmetrical", "ASymmetrical"), "0 90 180", "0 90 270");
  const TablePtr table = read(text);
  const auto across = [&](double sign) {
    const auto g = geometry_of(optics::radians(30.0),
                               {optics::radians(20.0), optics::radians(180.0 + sign * 90.0)});
    return optics::element(table->at(0.55, g), 0, 0);
  };
  EXPECT_NEAR(across(-1), 123, 1e-6);
  EXPECT_NEAR(across(1), 133, 1e-6);
  EXPECT_NEAR(m00(*table, 0.55, 30, 50, 0), 128, 1e-6);  // azimuth 180, between 90 and 270
}

TEST(Zemax, IsRefusedWithTheLineWhereItIsWrong) {
  const auto refuse = [](const std::string& what, const std::string& by,
                         const std::vector<std::string>& says) {
    expect_refused([&] { read(replaced(by_hand, what, by)); }, says);
  };
  refuse("0 90 180", "0 90 270", {"x.bsdf:11:", "ScatterAzimuth 270", "0 to 180"});
  refuse("PlaneSymmetrical", "Spherical", {":3:", "no symmetry 'Spherical'"});
  refuse("30 50", "30 90", {":9:", "AngleOfIncidence 90"});
  refuse("30 50", "50 30", {":9:", "does not rise"});
  refuse("BRDF", "BTDF", {":5:", "transmission"});
  refuse("SampleRotation  1\n0", "SampleRotation  2\n0 90", {":6:", "anisotropic"});
  refuse("122", "nan", {":19:", "'nan'"});
  refuse("122", "-1", {":19:", "negative"});
  refuse("133 134\n", "133\n", {":21:", "'TIS'"});
  refuse("ScatterRadial 4", "ScatterRadial 4000000000",
         {":12:", "more than the file has room for"});
  refuse("ScatterRadial 4", "ScatterRadial 0", {":12:"});
  refuse("DataEnd\n", "", {"end of the file", "DataEnd"});
  refuse("DataEnd\n", "DataEnd\n7\n", {":26:", "'7'"});
  refuse("TIS 0.6", "TIS -1", {":21:", "negative"});
}

TEST(Zemax, IsToldFromOtherFilesOfTheSameEnding) {
  EXPECT_TRUE(looks_like_zemax(by_hand));
  EXPECT_TRUE(looks_like_zemax("source measured"));
  EXPECT_FALSE(looks_like_zemax(std::string("tensor_file\0\1\0", 14)));
  EXPECT_FALSE(looks_like_zemax(""));
  EXPECT_FALSE(looks_like_zemax("theta_i_deg,theta_r_deg\n"));
}

}  // namespace
}  // namespace umov::formats
