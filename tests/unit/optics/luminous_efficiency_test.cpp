#include "host/optics/luminous_efficiency.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace umov::optics {
namespace {

TEST(LuminousEfficiency, HasThePublishedValuesAndIntegral) {
  EXPECT_EQ(luminous_efficiency(0.555), 1.0);
  EXPECT_NEAR(luminous_efficiency(0.510), 0.503, 1e-9);
  EXPECT_NEAR(luminous_efficiency(0.610), 0.503, 1e-9);
  EXPECT_NEAR(luminous_efficiency(0.360), 3.917e-6, 1e-12);
  EXPECT_NEAR(luminous_efficiency(0.830), 4.52e-7, 1e-12);
  EXPECT_EQ(luminous_efficiency(0.359), 0.0);
  EXPECT_EQ(luminous_efficiency(0.831), 0.0);
  double sum = 0.0;
  for (int nm = 380; nm <= 780; nm += 5) sum += luminous_efficiency(1e-3 * nm);
  EXPECT_NEAR(sum, 21.371,
              0.001);  // that of the CIE's other two functions too: they are made alike
}

// Luminous efficacies of black bodies are known: 54.7 lm/W at 4000 K, 95 lm/W at 7000 K.
TEST(LuminousEfficiency, GivesBlackBodiesTheirEfficacy) {
  const auto efficacy = [](double kelvin) {
    constexpr double c1 = 3.741772e-16, c2 = 1.438777e-2, sigma = 5.670374e-8;
    double lumens = 0.0;
    for (int i = 0; i < 4700; ++i) {
      const double nm = 360.05 + 0.1 * i;
      const double m = 1e-9 * nm;
      lumens += luminous_efficacy_lm_w * luminous_efficiency(1e-3 * nm) * c1 /
                (std::pow(m, 5) * std::expm1(c2 / (m * kelvin))) * 1e-10;
    }
    return lumens / (sigma * std::pow(kelvin, 4));
  };
  EXPECT_NEAR(efficacy(4000.0), 54.7, 0.1);
  EXPECT_NEAR(efficacy(7000.0), 95.0, 0.5);
}

}  // namespace
}  // namespace umov::optics
