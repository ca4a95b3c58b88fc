// The detector disc's average against one worked out ray by ray.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "host/calibrate/aperture.hpp"

namespace umov::calibrate {
namespace {

constexpr double rad = std::numbers::pi / 180;

/// A lobe of facets of rms slope s/√2 with a gently tilted top, on a diffuse ground, 1/sr.
double lobe(double theta_i_deg, double theta_r_deg, double phi_deg, double slope) {
  const double ti = theta_i_deg * rad, tr = theta_r_deg * rad, phi = phi_deg * rad;
  const double x = std::sin(ti) * -1 + std::sin(tr) * std::cos(phi);
  const double y = std::sin(tr) * std::sin(phi), z = std::cos(ti) + std::cos(tr);
  return 0.02 + 8 * std::exp(-(x * x + y * y) / (z * z * slope * slope)) / std::cos(tr);
}

/// Mean of f cosθr over the disc over the cosine of its middle, by rings of equal area.
double over_disc(double theta_i_deg, double theta_r_deg, double half_angle_deg, double slope) {
  double sum = 0;
  constexpr int rings = 20, spokes = 48;
  for (int r = 0; r < rings; ++r)
    for (int k = 0; k < spokes; ++k) {
      const double away = half_angle_deg * rad * std::sqrt((r + 0.5) / rings);
      const double turn = 2 * std::numbers::pi * (k + 0.5) / spokes;
      const double along = std::sin(away) * std::cos(turn), y = std::sin(away) * std::sin(turn);
      const double t = theta_r_deg * rad;
      const double x = std::cos(away) * std::sin(t) + along * std::cos(t);
      const double z = std::cos(away) * std::cos(t) - along * std::sin(t);
      sum += lobe(theta_i_deg, std::acos(z) / rad, std::atan2(y, x) / rad, slope) * z;
    }
  return sum / (rings * spokes) / std::cos(theta_r_deg * rad);
}

formats::BrdfTable::Points scan_of(double slope, double half_angle_deg) {
  formats::BrdfTable::Points p;
  for (double theta_r = 20; theta_r <= 60; ++theta_r) {
    p.theta_i_deg.push_back(40);
    p.theta_r_deg.push_back(theta_r);
    p.phi_r_deg.push_back(0);
    p.wavelength_nm.push_back(633);
    p.polarizer_deg.push_back(std::nan(""));
    p.analyzer_deg.push_back(std::nan(""));
    p.brdf_per_sr.push_back(over_disc(40, theta_r, half_angle_deg, slope));
    p.brdf_u.push_back(1e-3 * p.brdf_per_sr.back());
    p.used.push_back(1);
  }
  return p;
}

/// rms over the lobe of what is left of the excess, relative to its own.
double left_over(const formats::BrdfTable::Points& p, const ApertureExcess& found, double slope) {
  double left = 0, all = 0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const double middle = lobe(40, p.theta_r_deg[i], 0, slope);
    left += std::pow((p.brdf_per_sr[i] - found.per_sr[i] - middle) / middle, 2);
    all += std::pow((p.brdf_per_sr[i] - middle) / middle, 2);
  }
  return std::sqrt(left / all);
}

TEST(Aperture, AShapeGivesTheDiscsAverageAndPointsAloneGiveMostOfIt) {
  constexpr double slope = 0.06, half_angle_deg = 0.4;
  const auto points = scan_of(slope, half_angle_deg);
  const BrdfShape shape = [&](double theta_i, double theta_r, double phi, double, double, double) {
    return 3 * lobe(theta_i, theta_r, phi, slope);  // its level does not count
  };
  const auto exact = aperture_excess(points, shape, half_angle_deg);
  EXPECT_LT(left_over(points, exact, slope), 0.01);
  const auto rough = aperture_excess(points, angle_slopes(points), half_angle_deg);
  EXPECT_LT(left_over(points, rough, slope), 0.2);
  EXPECT_EQ(exact.too_narrow + rough.too_narrow, 0u);
  // At the peak it takes from the BRDF, and its doubt is a small part of it.
  EXPECT_LT(exact.per_sr[20], 0);
  EXPECT_NEAR(exact.doubt_per_sr[20] / exact.per_sr[20], 0.05, 1e-9);
  EXPECT_NEAR(rough.doubt_per_sr[20] / rough.per_sr[20], 0.2, 0.01);
}

TEST(Aperture, TheAnalyserKeepsItsAxisOverTheDisc) {
  // Light polarised along the x axis of the laboratory, seen near the normal behind crossed and
  // parallel analysers: the azimuth turns fast from ray to ray there, and the light does not.
  formats::BrdfTable::Points p = scan_of(0.1, 0);
  p.theta_r_deg.assign(p.size(), 2);
  p.analyzer_deg.assign(p.size(), 90);
  p.brdf_per_sr.assign(p.size(), 1e-3);
  const BrdfShape along_x = [](double, double, double phi, double, double, double analyzer) {
    // Towards s is towards smaller azimuths: the x axis stands at +φ from p there.
    return 1e-3 + std::pow(std::cos((analyzer - phi) * rad), 2);
  };
  const auto crossed = aperture_excess(p, along_x, 0.4);
  EXPECT_LT(std::abs(crossed.per_sr[0]), 1e-6);
}

TEST(Aperture, ALobeAsNarrowAsTheDiscIsLeftAloneWithADoubt) {
  const auto points = scan_of(0.004, 0.4);
  const auto found = aperture_excess(points, angle_slopes(points), 0.4);
  EXPECT_GT(found.too_narrow, 0u);
  EXPECT_EQ(found.per_sr[20], 0);
  EXPECT_NEAR(std::abs(found.doubt_per_sr[20]), 0.25 * points.brdf_per_sr[20], 1e-12);
}

}  // namespace
}  // namespace umov::calibrate
