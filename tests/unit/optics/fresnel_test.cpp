#include "host/optics/fresnel.hpp"

#include <gtest/gtest.h>

#include <complex>

namespace umov::optics {
namespace {

struct Material {
  double n, kappa;
};
const Material materials[] = {{1.5, 0.0}, {0.958, 6.69}, {5.39, 0.70},
                              {0.2, 3.4}, {1.33, 1e-8},  {0.7, 0.0}};

TEST(Fresnel, RealArithmeticMatchesComplexNumbers) {
  for (const Material& m : materials) {
    for (double degrees_i = 0.0; degrees_i < 90.0; degrees_i += 3.7) {
      const double c = std::cos(radians(degrees_i));
      const std::complex<double> index(m.n, m.kappa);
      const std::complex<double> eps = index * index;
      const std::complex<double> q = std::sqrt(eps - (1.0 - c * c));
      const std::complex<double> s = (c - q) / (c + q);
      const std::complex<double> p = (eps * c - q) / (eps * c + q);
      const FresnelAmplitudes<double> r = fresnel_amplitudes(m.n, m.kappa, c);
      EXPECT_NEAR(r.s.re, s.real(), 1e-13);
      EXPECT_NEAR(r.s.im, s.imag(), 1e-13);
      EXPECT_NEAR(r.p.re, p.real(), 1e-13);
      EXPECT_NEAR(r.p.im, p.imag(), 1e-13);
    }
  }
}

TEST(Fresnel, NormalIncidenceReversesP) {
  for (const Material& m : materials) {
    const FresnelAmplitudes<double> r = fresnel_amplitudes(m.n, m.kappa, 1.0);
    EXPECT_NEAR(r.p.re, -r.s.re, 1e-14);
    EXPECT_NEAR(r.p.im, -r.s.im, 1e-14);
    const Mueller<double> matrix = reflection_mueller(m.n, m.kappa, 1.0);
    EXPECT_NEAR(element(matrix, 2, 2), -element(matrix, 0, 0), 1e-14);
    EXPECT_NEAR(element(matrix, 3, 3), -element(matrix, 0, 0), 1e-14);
  }
}

TEST(Fresnel, PReflectionVanishesAtBrewstersAngle) {
  const double brewster = std::atan(1.5);
  EXPECT_LT(reflectance_p(1.5, 0.0, std::cos(brewster)), 1e-30);
  EXPECT_GT(reflectance_s(1.5, 0.0, std::cos(brewster)), 0.14);
}

TEST(Fresnel, GrazingIncidenceReflectsEverything) {
  for (const Material& m : materials) {
    EXPECT_NEAR(reflectance_s(m.n, m.kappa, 0.0), 1.0, 1e-14);
    EXPECT_NEAR(reflectance_p(m.n, m.kappa, 0.0), 1.0, 1e-14);
  }
}

TEST(Fresnel, TotalReflectionBeyondTheCriticalAngle) {
  const double critical = std::asin(0.7);
  EXPECT_NEAR(reflectance(0.7, 0.0, std::cos(critical + 0.01)), 1.0, 1e-14);
  EXPECT_LT(reflectance(0.7, 0.0, std::cos(critical - 0.01)), 0.9);
}

TEST(Fresnel, ASmoothInterfaceDoesNotDepolarise) {
  // For a pure (Jones) matrix of this form m00² - m01² = m22² + m23².
  for (const Material& m : materials) {
    for (const double c : {1.0, 0.8, 0.3, 0.02}) {
      const FresnelReflection<double> r = fresnel_reflection(m.n, m.kappa, c);
      EXPECT_NEAR(r.mean * r.mean - r.half_difference * r.half_difference,
                  r.cross_re * r.cross_re + r.cross_im * r.cross_im, 1e-14);
      EXPECT_NEAR(r.mean + transmittance(m.n, m.kappa, c), 1.0, 1e-15);
    }
  }
}

}  // namespace
}  // namespace umov::optics
