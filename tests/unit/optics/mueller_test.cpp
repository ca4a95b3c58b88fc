#include "host/optics/mueller.hpp"

#include <gtest/gtest.h>

namespace umov::optics {
namespace {

void expect_near(const Mueller<double>& a, const Mueller<double>& b, double tolerance) {
  for (int i = 0; i < 16; ++i) {
    EXPECT_NEAR(element(a, i / 4, i % 4), element(b, i / 4, i % 4), tolerance)
        << i / 4 << "," << i % 4;
  }
}

TEST(Polarizer, AxisAtZeroPassesPAndAtNinetyPassesS) {
  const Stokes<double> p = polarizer_stokes<double>(0.0);
  const Stokes<double> s = polarizer_stokes<double>(90.0);
  const Stokes<double> diagonal = polarizer_stokes<double>(45.0);
  EXPECT_NEAR(p[1], -1.0, 1e-15);
  EXPECT_NEAR(s[1], 1.0, 1e-15);
  EXPECT_NEAR(diagonal[2], 1.0, 1e-15);
  EXPECT_NEAR(diagonal[1], 0.0, 1e-15);
}

TEST(Polarizer, CrossedAnalyserBlocksAndParallelAnalyserPasses) {
  const Mueller<double> nothing = identity_mueller<double>();
  for (const double alpha : {0.0, 17.0, 45.0, 90.0, 133.0}) {
    EXPECT_NEAR(contract(analyzer_stokes<double>(alpha), nothing, polarizer_stokes<double>(alpha)),
                1.0, 1e-15);
    EXPECT_NEAR(
        contract(analyzer_stokes<double>(alpha + 90.0), nothing, polarizer_stokes<double>(alpha)),
        0.0, 1e-15);
  }
}

TEST(Polarizer, OpenDetectorSeesParallelPlusCrossed) {
  Mueller<double> m(0.0);
  for (int i = 0; i < 16; ++i) set_element(m, i / 4, i % 4, 0.1 * i + 1.0);
  const Stokes<double> source = polarizer_stokes<double>(20.0);
  EXPECT_NEAR(contract(unpolarized<double>(), m, source),
              contract(analyzer_stokes<double>(0.0), m, source) +
                  contract(analyzer_stokes<double>(90.0), m, source),
              1e-14);
}

TEST(Mueller, ElementsAreRowOutgoingColumnIncoming) {
  Mueller<double> m(0.0);
  set_element(m, 2, 0, 5.0);
  const Stokes<double> out = apply(m, unpolarized<double>());
  EXPECT_EQ(out[2], 5.0);
  EXPECT_EQ(element(m, 2, 0), 5.0);
  EXPECT_EQ(element(m, 0, 2), 0.0);
}

TEST(Mueller, RotatedBasisSeesTheSameLightAtTheReducedAngle) {
  // s' = s cos β + p sin β: light along s' is pure Q in the new basis.
  const double beta = radians(30.0);
  const Stokes<double> along_new_s(1.0, std::cos(2 * beta), std::sin(2 * beta), 0.0);
  const Stokes<double> seen = apply(rotation(beta), along_new_s);
  EXPECT_NEAR(seen[1], 1.0, 1e-15);
  EXPECT_NEAR(seen[2], 0.0, 1e-15);
}

TEST(Mueller, RotationsComposeAndInvert) {
  expect_near(product(rotation(0.4), rotation(0.3)), rotation(0.7), 1e-15);
  expect_near(product(rotation(0.4), rotation(-0.4)), identity_mueller<double>(), 1e-15);
}

TEST(Mueller, DepolarizerKeepsOnlyTheIntensity) {
  const Stokes<double> out = apply(depolarizer<double>(), polarizer_stokes<double>(30.0));
  EXPECT_EQ(out[0], 1.0);
  EXPECT_EQ(out[1], 0.0);
  EXPECT_EQ(out[2], 0.0);
  EXPECT_EQ(out[3], 0.0);
}

}  // namespace
}  // namespace umov::optics
