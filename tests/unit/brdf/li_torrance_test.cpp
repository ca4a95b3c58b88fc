#include "host/brdf/li_torrance.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "host/brdf/dhr.hpp"
#include "host/brdf/evaluate.hpp"

namespace umov::brdf {
namespace {

using optics::element;
using optics::radians;

/// n, kappa, sigma, tau, then the four weights, lobe width and polarisation.
std::vector<double> weights(double k_dd, double k_udf, double k_uds, double k_fs,
                            double width_deg = 15.0, double polarization = 0.5) {
  return {1.5, 0.0, 0.3, 3.0, k_dd, k_udf, k_uds, k_fs, width_deg, polarization};
}

const Model& model() {
  static const Model m = Model::by_name("li-torrance");
  return m;
}

optics::Mueller<double> value(const std::vector<double>& p, double theta_i, double theta_r,
                              double phi = 0.0) {
  return evaluate<double>(model(), p, 0.633,
                          Geometry<double>{radians(theta_i), radians(theta_r), radians(phi)});
}

TEST(LiTorrance, UnitDirectionalWeightIsTheHeTorranceLobe) {
  const auto full = value(weights(1, 0, 0, 0), 30, 40, 20);
  const auto lobe =
      evaluate<double>(Model::by_name("he-torrance"), std::vector{1.5, 0.0, 0.3, 3.0}, 0.633,
                       Geometry<double>{radians(30), radians(40), radians(20)});
  for (int i = 0; i < 16; ++i)
    EXPECT_DOUBLE_EQ(element(full, i / 4, i % 4), element(lobe, i / 4, i % 4));
}

TEST(LiTorrance, MirrorPartGoesWithTheDirectionalWeight) {
  std::vector<double> p = weights(0.5, 0.1, 0.1, 0.1);
  p[2] = 0.03;
  const Dhr half = mirror_dhr(model(), p, 0.633, 0.4);
  const Dhr whole =
      mirror_dhr(Model::by_name("he-torrance"), std::vector{1.5, 0.0, 0.03, 3.0}, 0.633, 0.4);
  EXPECT_NEAR(half.s, 0.5 * whole.s, 1e-15);
  EXPECT_GT(whole.s, whole.p);
}

TEST(LiTorrance, ForwardLobeIntegratesToItsWeightAtNormalIncidence) {
  for (const double width : {0.5, 5.0, 20.0, 60.0, 90.0}) {
    EXPECT_NEAR(dhr(model(), weights(0, 0, 0, 0.7, width), 0.633, 0.0).unpolarized, 0.7, 1e-6)
        << width;
  }
}

TEST(LiTorrance, UniformTermsIntegrateToTheirWeightsAtNormalIncidence) {
  EXPECT_NEAR(dhr(model(), weights(0, 0.03, 0, 0), 0.633, 0.0).unpolarized, 0.03, 1e-12);
  // By a plain quadrature too, since dhr() knows this integral in closed form.
  const std::vector<double> p = weights(0, 0, 0.48, 0);
  double sum = 0.0;
  constexpr int steps = 2000;
  for (int i = 0; i < steps; ++i) {
    const double theta = (i + 0.5) * 90.0 / steps;
    sum += element(value(p, 0.0, theta), 0, 0) * std::sin(radians(2.0 * theta)) * optics::pi *
           radians(90.0 / steps);
  }
  EXPECT_NEAR(sum, 0.48, 2e-7);
  EXPECT_NEAR(dhr(model(), p, 0.633, 0.0).unpolarized, 0.48, 1e-12);
  EXPECT_LT(dhr(model(), p, 0.633, radians(70)).unpolarized, 0.44);
}

TEST(LiTorrance, DiffuseTransmittanceMatchesAFineSum) {
  for (const auto& [n, kappa] :
       {std::pair{1.5, 0.0}, {1.05, 0.0}, {1.5, 0.3}, {0.8, 0.0}, {0.958, 6.69}}) {
    double sum = 0.0;
    constexpr int steps = 200000;
    for (int i = 0; i < steps; ++i) {
      const double mu = (i + 0.5) / steps;
      sum += 2.0 * mu * optics::transmittance(n, kappa, mu) / steps;
    }
    EXPECT_NEAR(diffuse_transmittance(n, kappa).value, sum, 1e-6) << n << " " << kappa;
    const double h = 1e-6;
    EXPECT_NEAR(
        diffuse_transmittance(n, kappa).partials[0],
        (diffuse_transmittance(n + h, kappa).value - diffuse_transmittance(n - h, kappa).value) /
            (2 * h),
        1e-5);
  }
}

TEST(LiTorrance, OnlyTheDiffuseTermsDepolarise) {
  const auto diffuse = value(weights(0, 0.1, 0.4, 0), 45, 45);
  for (int i = 1; i < 16; ++i) EXPECT_EQ(element(diffuse, i / 4, i % 4), 0.0);
  const auto forward = value(weights(0, 0, 0, 1, 15.0, 0.6), 45, 30);
  EXPECT_NEAR(element(forward, 1, 1) / element(forward, 0, 0), 0.6, 1e-12);
  EXPECT_NEAR(element(forward, 2, 2) / element(forward, 0, 0), -0.6, 1e-12);
  EXPECT_NEAR(element(forward, 3, 3) / element(forward, 0, 0), -0.6, 1e-12);
  EXPECT_NEAR(element(forward, 0, 1), 0.0, 1e-15);
}

TEST(LiTorrance, ForwardLobeFallsWithTheAngleFromTheMirrorDirection) {
  const std::vector<double> p = weights(0, 0, 0, 1, 10.0);
  const double peak = element(value(p, 40, 40), 0, 0);
  EXPECT_NEAR(element(value(p, 40, 50), 0, 0) / peak, std::exp(-0.5), 1e-12);
  EXPECT_NEAR(element(value(p, 40, 30), 0, 0) / peak, std::exp(-0.5), 1e-12);
  EXPECT_NEAR(element(value(p, 40, 60), 0, 0) / peak, std::exp(-2.0), 1e-12);
}

TEST(LiTorrance, SquaredAngleIsExactFromZeroToTheFarSide) {
  for (const double alpha : {0.0, 1e-7, 1e-3, 0.5, 2.0, 3.1}) {
    const double chord = 2.0 * std::sin(0.5 * alpha);
    EXPECT_NEAR(squared_angle(chord * chord), alpha * alpha, 1e-13 * (1.0 + alpha)) << alpha;
  }
}

}  // namespace
}  // namespace umov::brdf
