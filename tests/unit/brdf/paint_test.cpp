// Paints: Beard and Maxwell's model, and light from below an interface.
#include <gtest/gtest.h>

#include <cmath>

#include "host/brdf/dhr.hpp"
#include "host/brdf/evaluate.hpp"

namespace umov::brdf {
namespace {

using optics::element;
using optics::Mueller;
using optics::radians;

TEST(BeardMaxwell, WithGaussianSlopesAndTheScanOfFacetsIsTheMicrofacetModel) {
  const double n = 1.5, kappa = 0.2, slope = 0.2, omega = 0.6, tau = 0.3;
  const double scan = optics::reflectance(n, kappa, 1.0) / (8.0 * optics::pi * slope * slope);
  const Model paint = Model::by_name("beard-maxwell:slopes=gaussian");
  const Model facets = Model::by_name("microfacet:shadowing=maxwell-beard");
  for (const double phi : {0.0, 50.0, 140.0}) {
    const Geometry<double> g{radians(40.0), radians(55.0), radians(phi)};
    const Mueller<double> a =
        evaluate<double>(paint, std::vector{n, kappa, slope, scan, omega, tau, 0.0, 0.0}, 0.633, g);
    const Mueller<double> b =
        evaluate<double>(facets, std::vector{n, kappa, slope, 1.0, omega, tau}, 0.633, g);
    for (int k = 0; k < 16; ++k)
      EXPECT_NEAR(element(a, k / 4, k % 4), element(b, k / 4, k % 4), 1e-12 * element(b, 0, 0));
  }
}

TEST(BeardMaxwell, ShowsTheTabulatedScanWhenSourceAndDetectorCoincide) {
  // Zero bistatic angle: B exp(-(θh/σ)²), σ = √2 slope_rms, and the volume light.
  const Model model = Model::by_name("beard-maxwell");
  const double bias = 0.7, slope = 0.2, rho_d = 0.05, rho_v = 0.03;
  for (const double theta : {0.0, 0.2, 0.7}) {
    const Mueller<double> m =
        evaluate<double>(model, std::vector{1.5, 0.2, slope, bias, 0.7, 0.25, rho_d, rho_v}, 0.633,
                         Geometry<double>{theta, -theta, 0.0});
    const double scan = bias * std::exp(-0.5 * theta * theta / (slope * slope));
    EXPECT_NEAR(element(m, 0, 0), scan + rho_d + rho_v / std::cos(theta), 1e-12);
  }
}

TEST(BeardMaxwell, HasNoFirstSurfaceWhereTheIndexMatchesVacuum) {
  const Model model = Model::by_name("beard-maxwell");
  const Mueller<double> m =
      evaluate<double>(model, std::vector{1.0, 0.0, 0.2, 0.5, 0.7, 0.25, 0.05, 0.0}, 0.633,
                       Geometry<double>{0.3, 0.3, 0.0});
  EXPECT_DOUBLE_EQ(element(m, 0, 0), 0.05);
}

TEST(Subsurface, OfAWhiteBodyReturnsAllThatTheInterfaceLetsIn) {
  const Model model = Model::by_name("subsurface");
  for (const double degrees_i : {0.0, 45.0, 80.0}) {
    const double cosine = std::cos(radians(degrees_i));
    const Dhr d = dhr(model, std::vector{1.5, 1.0}, 0.633, radians(degrees_i));
    EXPECT_NEAR(d.unpolarized, 1.0 - optics::reflectance(1.5, 0.0, cosine), 2e-6) << degrees_i;
    EXPECT_NEAR(d.s, 1.0 - optics::reflectance_s(1.5, 0.0, cosine), 2e-6) << degrees_i;
    EXPECT_NEAR(d.p, 1.0 - optics::reflectance_p(1.5, 0.0, cosine), 2e-6) << degrees_i;
  }
}

TEST(Subsurface, IsForUnpolarisedLightTheSubsurfaceTermOfLiTorrance) {
  const double n = 1.5, rho = 0.6;
  const double at_normal =
      dhr(Model::by_name("subsurface"), std::vector{n, rho}, 0.633, 0.0).unpolarized;
  for (const double theta_r : {0.1, 0.9, 1.4}) {
    const Geometry<double> g{0.8, theta_r, 1.0};
    const Mueller<double> body =
        evaluate<double>(Model::by_name("subsurface"), std::vector{n, rho}, 0.633, g);
    const Mueller<double> term = evaluate<double>(
        Model::by_name("li-torrance"),
        std::vector{n, 0.0, 0.3, 3.0, 0.0, 0.0, at_normal, 0.0, 15.0, 0.0}, 0.633, g);
    EXPECT_NEAR(element(body, 0, 0), element(term, 0, 0), 2e-6);
    // Leaving obliquely polarises it in p.
    EXPECT_LT(element(body, 1, 0), 0.0);
  }
}

TEST(SingleScatter, WithoutAnInterfaceIsLommelAndSeeliger) {
  const Model model = Model::by_name("single-scatter");
  const Geometry<double> g{0.6, 1.1, 2.0};
  const Mueller<double> m = evaluate<double>(model, std::vector{1.0, 0.8, 0.0}, 0.633, g);
  EXPECT_NEAR(element(m, 0, 0), 0.8 / (4.0 * optics::pi * (std::cos(0.6) + std::cos(1.1))), 1e-14);
  EXPECT_NEAR(element(m, 0, 1), 0.0, 1e-14);
}

TEST(SingleScatter, NeverReturnsMoreThanItGets) {
  for (const double n : {1.0, 1.33, 2.5}) {
    for (const double asymmetry : {-0.9, 0.0, 0.9}) {
      for (const double degrees_i : {0.0, 60.0, 88.0}) {
        const Dhr d = dhr(Model::by_name("single-scatter"), std::vector{n, 1.0, asymmetry}, 0.633,
                          radians(degrees_i));
        const double entered = 1.0 - optics::reflectance(n, 0.0, std::cos(radians(degrees_i)));
        EXPECT_LE(d.unpolarized, entered + 1e-6) << n << " " << asymmetry << " " << degrees_i;
      }
    }
  }
}

}  // namespace
}  // namespace umov::brdf
