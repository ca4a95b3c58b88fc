// Intensity distributions: the two file formats, and lumens from candela.
#include <gtest/gtest.h>

#include <cmath>

#include "host/formats/photometry.hpp"
#include "host/optics/angles.hpp"
#include "tests/unit/failure.hpp"
#include "tests/unit/optional_data.hpp"

namespace umov::formats {
namespace {

using optics::pi;

/// cos γ forwards, a little fuller towards C0.
Photometry lamp() {
  Photometry p;
  p.maker = "nobody";
  p.name = "test lamp";
  p.report = "no. 7";
  p.lamp_lm = 4.0;
  p.length_mm = 43.0;
  for (int c = 0; c < 8; ++c) p.c_deg.push_back(45.0 * c);
  for (int g = 0; g <= 36; ++g) p.gamma_deg.push_back(5.0 * g);
  for (const double c : p.c_deg) {
    for (const double g : p.gamma_deg) {
      const double cosine = std::max(0.0, std::cos(optics::radians(g)));
      p.candela.push_back(cosine * (1.0 + 0.2 * std::cos(optics::radians(c))));
    }
  }
  return p;
}

TEST(Photometry, ACosineOfOneCandelaIsPiLumens) {
  const Photometry p = lamp();
  EXPECT_NEAR(p.zonal_lm(), pi, 2e-3);
  EXPECT_NEAR(p.zonal_lm(0.0, 60.0), pi * 0.75, 2e-3);
  EXPECT_EQ(p.zonal_lm(95.0, 180.0), 0.0);
  EXPECT_NEAR(p.intensity(22.5, 0.0), 0.5 * (1.2 + 1.0 + 0.2 * std::sqrt(0.5)), 1e-12);
  EXPECT_NEAR(p.intensity(-22.5, 0.0), p.intensity(337.5, 0.0), 1e-12);
}

TEST(Photometry, BothFormatsBringBackWhatTheyWereGiven) {
  const Photometry p = lamp();
  for (const std::string& text : {ies_text(p), eulumdat_text(p)}) {
    const Photometry back = parse_photometry(text, "lamp");
    EXPECT_EQ(back.c_deg, p.c_deg);
    EXPECT_EQ(back.gamma_deg, p.gamma_deg);
    ASSERT_EQ(back.candela.size(), p.candela.size());
    for (std::size_t i = 0; i < p.candela.size(); ++i)
      EXPECT_NEAR(back.candela[i], p.candela[i], 1e-6);
    EXPECT_EQ(back.name, "test lamp");
    EXPECT_EQ(back.report, "no. 7");
    EXPECT_NEAR(back.lamp_lm, 4.0, 1e-9);
    EXPECT_NEAR(back.length_mm, 43.0, 1e-9);
    EXPECT_EQ(back.width_mm, 0.0);
  }
}

TEST(Photometry, AQuadrantStandsForTheWholeCircle) {
  const std::string text =
      "IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 3 3 1 2 0 0 0\n1 1 10\n0 45 90\n0 45 90\n"
      "5 4 1\n5 3 1\n5 2 1\n";
  const Photometry p = parse_ies(text, "quadrant.ies");
  ASSERT_EQ(p.c_deg, (std::vector<double>{0, 45, 90, 135, 180, 225, 270, 315}));
  EXPECT_EQ(p.intensity(135.0, 45.0), 3.0);
  EXPECT_EQ(p.intensity(180.0, 45.0), 4.0);
  EXPECT_EQ(p.intensity(270.0, 45.0), 2.0);
  EXPECT_EQ(p.lamp_lm, 0.0);
}

TEST(Photometry, BadFilesAreRefusedWithPlaceAndRemedy) {
  const std::string head = "IESNA:LM-63-2002\nTILT=NONE\n";
  const auto says = [](const std::string& text) {
    return failure_of([&] { parse_photometry(text, "x.ies"); });
  };
  EXPECT_EQ(says(head + "1 100 1 2 1 2 2 0 0 0\n"),
            "x.ies:3:photometric type: is not 1 (type C) (types A and B are not read)");
  EXPECT_NE(says(head + "1 100 1 2 1 1 2 0 0 0\n1 1 10\n0 90\n0\n5 -1\n").find("candela: is -1"),
            std::string::npos);
  EXPECT_NE(says(head + "1 100 1 2 1 1 2 0 0 0\n1 1 10\n0 90\n0\n5\n").find("cut off"),
            std::string::npos);
  EXPECT_NE(says(head + "1 100 1 2 1 1 2 0 0 0\n1 1 10\n90 0\n0\n5 1\n").find("does not rise"),
            std::string::npos);
  EXPECT_NE(says("TILT=INCLUDE\n").find("TILT=NONE"), std::string::npos);
  EXPECT_NE(says("a\n1\n9\n").find("symmetry"), std::string::npos);
}

TEST(Photometry, NumbersOfNoLuminaireAreRefused) {
  const auto says = [](const std::string& text) {
    return failure_of([&] { parse_photometry(text, "x.ies"); });
  };
  const std::string head = "IESNA:LM-63-2002\nTILT=NONE\n";
  // Products that overflow, too.
  EXPECT_NE(says(head + "1 100 1e300 2 1 1 2 0 0 0\n1 1 10\n0 90\n0\n5 1e300\n").find("candela"),
            std::string::npos);
  EXPECT_NE(says(head + "1e200 1e200 1 2 1 1 2 0 0 0\n1 1 10\n0 90\n0\n5 1\n").find("lumens"),
            std::string::npos);
  EXPECT_NE(says(head + "1 100 1 2 1 1 2 1e300 0 0\n1 1 10\n0 90\n0\n5 1\n").find("width"),
            std::string::npos);
}

TEST(Photometry, EulumdatRefusesWhatItCannotHold) {
  Photometry p = lamp();
  p.gamma_deg = {0.0};
  p.candela.assign(p.c_deg.size(), 1.0);
  EXPECT_NE(failure_of([&] { eulumdat_text(p); }).find("8 planes of 1 angles"), std::string::npos);
  EXPECT_TRUE(looks_like_photometry(eulumdat_text(lamp())));
  EXPECT_TRUE(looks_like_photometry(ies_text(lamp())));
  EXPECT_FALSE(looks_like_photometry("plane,theta_i_deg\n1\n2\n"));
}

// Angles that differ in their eighth digit stay apart.
TEST(Photometry, AnglesComeBackBitByBit) {
  Photometry p = lamp();
  p.gamma_deg[1] = 5.0000001;
  p.gamma_deg[2] = 5.0000002;
  for (const std::string& text : {ies_text(p), eulumdat_text(p)})
    EXPECT_EQ(parse_photometry(text, "lamp").gamma_deg, p.gamma_deg);
}

// Files of manufacturers; their own statements of flux.
TEST(Photometry, RealFilesHoldTheFluxTheyState) {
  const auto folder = umov::testing::optional_data("photometry");
  if (!folder) GTEST_SKIP() << "no photometry/: name its folder in UMOV_DATA";
  EXPECT_NEAR(read_photometry(*folder / "examp1.ies").zonal_lm() / 5297.0, 1.0, 0.003);
  for (const char* name : {"sample1.ldt", "sample4.ldt"}) {
    const Photometry p = read_photometry(*folder / name);
    EXPECT_NEAR(p.zonal_lm() / p.lamp_lm, 1.0, 0.003) << name;
  }
}

}  // namespace
}  // namespace umov::formats
