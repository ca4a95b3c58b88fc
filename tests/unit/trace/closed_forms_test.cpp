// Scenes whose answer is known in closed form.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "host/optics/fresnel.hpp"
#include "tests/unit/trace/scenes.hpp"

namespace umov::trace {
namespace {

using optics::element;
using optics::Mueller;
using optics::pi;
using optics::radians;
using test::Mean;
using test::shine;

constexpr double sigmas = 4.0;  // declared: a right program fails one comparison in 16,000

Medium water(double n = 1.33, double kappa = 0.0) {
  return {{n}, {kappa}};
}

TEST(Mirror, HasTheMuellerMatrixOfFresnelInTheMirrorDirection) {
  for (const double degrees : {0.0, 20.0, 60.0, 89.0}) {
    Scene scene({0.5, 0.6});
    scene.add_plane(0.0, scene.add(Conductor{{1.2, 4.0}, {6.0, 0.1}}));
    const double theta = radians(degrees);
    int exits = 0;
    shine(scene, theta, 20, 1, [&](const Exit& exit) {
      ++exits;
      const Mueller<double> expected = optics::reflection_mueller(
          exit.wavelength == 0 ? 1.2 : 4.0, exit.wavelength == 0 ? 6.0 : 0.1, std::cos(theta));
      EXPECT_NEAR(exit.direction.x, std::sin(theta), 1e-12);
      EXPECT_NEAR(exit.direction.z, std::cos(theta), 1e-12);
      for (int i = 0; i < 16; ++i) {
        EXPECT_NEAR(element(exit.weight, i / 4, i % 4), element(expected, i / 4, i % 4), 1e-12)
            << degrees << "°, element " << i / 4 << i % 4;
      }
    });
    EXPECT_EQ(exits, 40);
  }
}

TEST(Mirror, OfAModelKeepsItsMatrixToo) {
  // Facets within .1° of the horizontal: a mirror, here through the frames of host/brdf.
  Scene scene({0.633});
  const brdf::Model model = brdf::Model::by_name("microfacet");
  std::vector<double> values{1.5, 0.5, 0.002, 1.0};
  scene.add_plane(0.0, scene.add(Modelled{brdf::Sampler(model, values, 0.633)}));
  const double theta = radians(55.0);
  const Mueller<double> expected = optics::reflection_mueller(1.5, 0.5, std::cos(theta));
  std::array<Mean, 16> means;
  Mueller<double> sum(0.0);
  shine(
      scene, theta, 2000, 2, [&](const Exit& exit) { sum += exit.weight; },
      [&] {
        for (int i = 0; i < 16; ++i)
          means[static_cast<std::size_t>(i)].add(element(sum, i / 4, i % 4));
        sum = Mueller<double>(0.0);
      });
  for (int i = 0; i < 16; ++i) {
    EXPECT_NEAR(means[static_cast<std::size_t>(i)].value(), element(expected, i / 4, i % 4), 1e-3)
        << "element " << i / 4 << i % 4;
  }
}

TEST(Furnace, ALambertianWorldWithoutAbsorptionReturnsAllLight) {
  // Spheres that touch the ground, one another and the edges of the period.
  Scene scene({0.5});
  const MaterialId white = scene.add(Lambertian{{1.0}});
  scene.add_plane(0.0, white);
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) {
      scene.spheres.push_back({Vec3(0.25 * i, 0.25 * j + 0.05, 0.125), 0.125, white});
    }
  }
  for (const double degrees : {0.0, 60.0, 89.0}) {
    double above = 0.0;
    std::uint32_t most = 0;
    const Ledger ledger = shine(scene, radians(degrees), 20000, 3, [&](const Exit& exit) {
      above += exit.weight[0][0];
      most = std::max(most, exit.meetings);
    });
    EXPECT_NEAR(above / 20000.0, 1.0, 1e-3) << degrees;
    EXPECT_NEAR(ledger.lost[0] / ledger.launched[0], 0.0, 1e-4) << degrees;
    EXPECT_EQ(ledger.absorbed[0], 0.0);
    EXPECT_GT(most, 20u);
  }
}

TEST(Balance, WhatGoesInIsReflectedAbsorbedOrCountedAsLost) {
  // Roulette, absorption in bulk and at faces, a drop of 180°, a cap, dirt, grazing light.
  Scene scene({0.5, 0.9});
  const MediumId wet = scene.add(Medium{{1.34, 1.33}, {0.0, 0.05}});
  const MaterialId ground = scene.add(Lambertian{{0.5, 0.3}});
  const MaterialId skin = scene.add(Interface{wet});
  const MaterialId soil = scene.add(Lambertian{{0.9, 0.2}});
  scene.add_plane(0.0, ground);
  scene.spheres.push_back({Vec3(0.2, 0.2, 0.2), 0.2, skin});
  scene.spheres.push_back({Vec3(0.7, 0.2, 0.1), 0.2, skin, 0.0});
  scene.spheres.push_back({Vec3(0.7, 0.7, -0.1), 0.24, skin, 0.0});
  scene.spheres.push_back({Vec3(0.2, 0.7, 0.2), 0.2, soil});
  for (const double degrees : {20.0, 89.0}) {
    const std::uint64_t launches = 60000;
    const Ledger l = shine(scene, radians(degrees), launches, 4, [](const Exit&) {});
    for (std::size_t i = 0; i < 2; ++i) {
      const double out = l.above[i] + l.below[i] + l.absorbed[i] + l.lost[i];
      // Roulette and the shared choice at interfaces balance in the mean only.
      EXPECT_NEAR(out / l.launched[i], 1.0, 4e-3) << degrees << "°, wavelength " << i;
      EXPECT_LE(l.lost[i] + l.below[i], 1e-4 * l.launched[i]) << degrees;
      EXPECT_GT(l.absorbed[i], 0.1 * l.launched[i]);
    }
  }
}

TEST(MirrorSphere, ScattersUniformly) {
  Scene scene({0.5});
  scene.periodic = false;
  // Large κ: all is reflected.
  scene.spheres.push_back({Vec3(0.0, 0.0, 0.0), 1.0, scene.add(Conductor{{1.0}, {1e7}})});
  const Geometry geometry(scene);
  const PathTracer tracer(scene, geometry);
  PathTracer::Workspace workspace(tracer);
  Ledger ledger(1);
  std::array<int, 48> bins{};
  test::Each collector([&](const Exit& exit) {
    EXPECT_NEAR(exit.weight[0][0], 1.0, 1e-6);
    const int ring = std::min(5, static_cast<int>(3.0 * (exit.direction.z + 1.0)));
    const double azimuth = std::atan2(exit.direction.y, exit.direction.x);
    const int sector = std::min(7, static_cast<int>(4.0 * (azimuth / pi + 1.0)));
    ++bins[static_cast<std::size_t>(8 * ring + sector)];
  });
  const int launches = 48000;
  for (int i = 0; i < launches; ++i) {
    const auto u = uniforms(5, static_cast<std::uint64_t>(i), 0);
    const double r = std::sqrt(u[0]);
    tracer.trace(Vec3(r * std::cos(2.0 * pi * u[1]), r * std::sin(2.0 * pi * u[1]), 3.0),
                 optics::incident_beam(0.0), 5, static_cast<std::uint64_t>(i), workspace, collector,
                 ledger);
  }
  double chi2 = 0.0;
  for (const int n : bins) chi2 += (n - 1000.0) * (n - 1000.0) / 1000.0;
  // 47 degrees of freedom: mean 47, σ = √94.
  EXPECT_LT(chi2, 47.0 + sigmas * std::sqrt(94.0));
}

TEST(WaterSphere, HasItsRainbowAtItsAngleAndPolarisation) {
  Scene scene({0.4, 0.7});
  scene.periodic = false;
  const std::vector<double> n{1.343, 1.331};
  // Descartes: the scattering angle of one internal reflection is least where cos²θ = (n² - 1)/3.
  std::array<double, 2> cosine{}, rainbow{};
  for (std::size_t w = 0; w < 2; ++w) {
    cosine[w] = std::sqrt((n[w] * n[w] - 1.0) / 3.0);
    const double entry = std::acos(cosine[w]);
    rainbow[w] = 180.0 + optics::degrees(2.0 * entry - 4.0 * std::asin(std::sin(entry) / n[w]));
  }
  const MediumId drop = scene.add(Medium{n, {0.0, 0.0}});
  scene.spheres.push_back({Vec3(0.0, 0.0, 0.0), 1.0, scene.add(Interface{drop})});
  const Geometry geometry(scene);
  const PathTracer tracer(scene, geometry);
  PathTracer::Workspace workspace(tracer);
  Ledger ledger(2);
  // Order 1: in, once reflected, out = 3 meetings. Least scattering angle; light and Q near it.
  std::array<double, 2> least{180.0, 180.0};
  std::array<double, 2> light{}, q{};
  test::Each collector([&](const Exit& exit) {
    const double angle = optics::degrees(std::acos(std::clamp(-exit.direction.z, -1.0, 1.0)));
    const std::size_t w = exit.wavelength;
    if (exit.meetings == 3) {
      least[w] = std::min(least[w], angle);
      if (angle < rainbow[w] + 0.1) {
        light[w] += exit.weight[0][0];
        // Q in the scattering plane: that is the exit basis {s, p}; incoming light unpolarised.
        q[w] += exit.weight[0][1];
      }
    }
  });
  for (std::uint64_t i = 0; i < 60000; ++i) {
    const auto u = uniforms(6, i, 0);
    const double r = std::sqrt(u[0]);
    tracer.trace(Vec3(r * std::cos(2.0 * pi * u[1]), r * std::sin(2.0 * pi * u[1]), 3.0),
                 optics::incident_beam(0.0), 6, i, workspace, collector, ledger);
  }
  for (std::size_t w = 0; w < 2; ++w) {
    EXPECT_NEAR(least[w], rainbow[w], 0.02) << n[w];
    EXPECT_GE(least[w], rainbow[w] - 1e-9) << "no light of this order is beyond its rainbow";
    EXPECT_GT(least[w], 137.0);
    EXPECT_LT(least[w], 139.5);
    // The ray of the rainbow, both transmissions and the internal reflection, s against p.
    const double rs = optics::reflectance_s(n[w], 0.0, cosine[w]);
    const double rp = optics::reflectance_p(n[w], 0.0, cosine[w]);
    const double s = (1 - rs) * (1 - rs) * rs;
    const double p = (1 - rp) * (1 - rp) * rp;
    EXPECT_NEAR(q[w] / light[w], (s - p) / (s + p), 0.03) << "the primary bow is s polarised";
  }
  EXPECT_GT(least[0], least[1] + 1.0) << "violet scatters farther than red: it is inside the bow";
  EXPECT_NEAR(ledger.above[0] + ledger.below[0], ledger.launched[0], 0.02 * ledger.launched[0]);
  EXPECT_EQ(ledger.lost[0] + ledger.lost[1], 0.0);
  EXPECT_EQ(ledger.in_wrong_medium + ledger.behind_opaque + ledger.endless, 0u);
}

// 2 ∫ f(cos θ) cos θ dcos θ over the hemisphere.
template <class F>
double hemispherical(const F& f) {
  constexpr int steps = 20000;
  double sum = 0.0;
  for (int i = 0; i < steps; ++i) {
    const double c = (i + 0.5) / steps;
    sum += 2.0 * f(c) * c / steps;
  }
  return sum;
}

TEST(WaterFilm, OnALambertianGroundHasItsAnalyticReflectance) {
  constexpr double n = 1.33;
  constexpr double ground = 0.6;
  Scene scene({0.5});
  scene.add_plane(0.0, scene.add(Lambertian{{ground}}));
  const MediumId film = scene.add(water(n));
  scene.add_plane(0.05, scene.add(Interface{film}));
  const double inside =
      hemispherical([](double c) { return optics::reflectance(1.0 / n, 0.0, c); });
  for (const double degrees : {0.0, 60.0, 80.0}) {
    const double theta = radians(degrees);
    const double surface = optics::reflectance(n, 0.0, std::cos(theta));
    const double diffuse = (1.0 - surface) * ground * (1.0 - inside) / (1.0 - ground * inside);
    Mean all, body, body_q;
    double sum = 0.0, within = 0.0, within_q = 0.0;
    shine(
        scene, theta, 600000, 7,
        [&](const Exit& exit) {
          sum += exit.weight[0][0];
          if (exit.meetings > 1) {
            within += exit.weight[0][0];
            within_q += exit.weight[0][1];
          }
        },
        [&] {
          all.add(sum), body.add(within), body_q.add(within_q);
          sum = within = within_q = 0.0;
        });
    EXPECT_NEAR(all.value(), surface + diffuse, sigmas * all.error()) << degrees;
    EXPECT_NEAR(body.value(), diffuse, sigmas * body.error()) << degrees;
    EXPECT_LT(all.error(), 0.002 * all.value());
    // Refraction polarises what comes from below: p passes more easily. Averaged over exits.
    const double t = hemispherical([&](double c) {
      const double r = optics::reflectance(n, 0.0, c);
      return 1.0 - r;
    });
    const double dt = hemispherical([&](double c) {
      return 0.5 * (optics::reflectance_p(n, 0.0, c) - optics::reflectance_s(n, 0.0, c));
    });
    EXPECT_NEAR(body_q.value(), diffuse * dt / t, sigmas * body_q.error()) << degrees;
  }
}

TEST(Absorption, FollowsBeerAndLambertOverTheRefractedPath) {
  constexpr double n = 1.5;
  constexpr double kappa = 0.02;
  constexpr double wavelength = 0.8;
  constexpr double depth = 0.5;
  Scene scene({wavelength});
  const MediumId glass = scene.add(Medium{{n}, {kappa}});
  scene.add_plane(0.0, scene.add(Conductor{{1.0}, {1e7}}));
  scene.add_plane(depth, scene.add(Interface{glass}));
  const double theta = radians(50.0);
  const double cosine = std::sqrt(1.0 - std::pow(std::sin(theta) / n, 2));
  const double through = std::exp(-4.0 * pi * kappa / wavelength * 2.0 * depth / cosine);
  // s and p each bounce between the faces on their own; m00 is their mean.
  double expected = 0.0;
  for (const double r : {optics::reflectance_s(n, 0.0, std::cos(theta)),
                         optics::reflectance_p(n, 0.0, std::cos(theta))}) {
    expected += 0.5 * (r + (1 - r) * (1 - r) * through / (1 - r * through));
  }
  Mean mean;
  double sum = 0.0;
  shine(
      scene, theta, 40000, 8, [&](const Exit& exit) { sum += exit.weight[0][0]; },
      [&] { mean.add(sum), sum = 0.0; });
  // κ itself changes the reflection at the face by less than 1e-4.
  EXPECT_NEAR(mean.value(), expected, sigmas * mean.error() + 1e-4);
  EXPECT_LT(mean.error(), 2e-3);
}

}  // namespace
}  // namespace umov::trace
