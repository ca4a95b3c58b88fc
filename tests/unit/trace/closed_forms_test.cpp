// Scenes whose answer is known in closed form.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <vector>

#include "host/optics/fresnel.hpp"
#include "host/trace/launch.hpp"
#include "tests/unit/trace/scenes.hpp"

namespace umov::trace {
namespace {

using optics::element;
using optics::Mueller;
using optics::pi;
using optics::radians;
using test::Mean;
using test::shine;

constexpr double sigmas = 3.0;  // declared; seeds are fixed, so what passes once always does

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

// Light from above evenly over the disc of a unit sphere at the origin, in `blocks` of `launches`.
// `act` gets each exit and how far from the axis its light came, `end` is called after each block.
Ledger shine_on_sphere(const Scene& scene, std::uint64_t blocks, std::uint64_t launches,
                       std::uint64_t seed, const std::function<void(const Exit&, double)>& act,
                       const std::function<void()>& end) {
  const Geometry geometry(scene);
  const PathTracer tracer(scene, geometry);
  PathTracer::Workspace workspace(tracer);
  Ledger ledger(scene.wavelengths_um.size());
  double r = 0.0;
  test::Each collector([&](const Exit& exit) { act(exit, r); });
  for (std::uint64_t block = 0; block < blocks; ++block) {
    for (std::uint64_t i = 0; i < launches; ++i) {
      const std::uint64_t sample = block * launches + i;
      const auto at = launch_point(i, launches, uniforms(seed, sample, 0));
      r = std::sqrt(at[0]);
      const double azimuth = 2.0 * pi * at[1];
      tracer.trace(Vec3(r * std::cos(azimuth), r * std::sin(azimuth), 3.0),
                   optics::incident_beam(0.0), seed, sample, workspace, collector, ledger);
    }
    end();
  }
  return ledger;
}

TEST(MirrorSphere, ScattersUniformly) {
  Scene scene({0.5});
  scene.periodic = false;
  // Large κ: all is reflected.
  scene.spheres.push_back({Vec3(0.0, 0.0, 0.0), 1.0, scene.add(Conductor{{1.0}, {1e7}})});
  constexpr std::size_t rings = 6;
  constexpr std::size_t sectors = 8;
  constexpr std::uint64_t launches = 10'000;
  std::array<double, rings * sectors> counts{};
  std::array<Mean, rings * sectors> means;
  shine_on_sphere(
      scene, 60, launches, 5,
      [&](const Exit& exit, double) {
        EXPECT_NEAR(exit.weight[0][0], 1.0, 1e-6);
        const auto ring =
            std::min(rings - 1, static_cast<std::size_t>(0.5 * rings * (exit.direction.z + 1.0)));
        const double azimuth = std::atan2(exit.direction.y, exit.direction.x);
        const auto sector =
            std::min(sectors - 1, static_cast<std::size_t>(0.5 * sectors * (azimuth / pi + 1.0)));
        ++counts[sectors * ring + sector];
      },
      [&] {
        for (std::size_t i = 0; i < counts.size(); ++i) {
          means[i].add(counts[i] * static_cast<double>(counts.size()) / launches);
        }
        counts = {};
      });
  for (const Mean& mean : means) {
    EXPECT_NEAR(mean.value(), 1.0, sigmas * mean.error());
    EXPECT_LT(mean.error(), 0.002);
  }
}

// Light that enters a sphere of index n at cosine c and leaves after k reflections inside (k = -1:
// light reflected outside), by geometrical optics.
struct Order {
  double scattering;  // radians, 0 to π
  double s, p;        // shares of power
};

Order order_of(double n, double c, int k) {
  const double rs = optics::reflectance_s(n, 0.0, c);
  const double rp = optics::reflectance_p(n, 0.0, c);
  const double outside = std::acos(c);
  const double inside = std::asin(std::sin(outside) / n);
  if (k < 0) return {pi - 2.0 * outside, rs, rp};
  const double turned = 2.0 * (outside - inside) + k * (pi - 2.0 * inside);
  return {std::acos(std::cos(turned)), (1 - rs) * (1 - rs) * std::pow(rs, k),
          (1 - rp) * (1 - rp) * std::pow(rp, k)};
}

TEST(WaterSphere, SendsEveryOrderWhereItBelongsWithItsPolarisation) {
  constexpr double n = 1.333;
  Scene scene({0.5});
  scene.periodic = false;
  const MediumId drop = scene.add(water(n));
  scene.spheres.push_back({Vec3(0.0, 0.0, 0.0), 1.0, scene.add(Interface{drop})});
  // Reflected outside; transmitted; of the primary and of the secondary bow.
  constexpr std::size_t orders = 4;
  std::array<double, orders> light{};
  std::array<Mean, orders> means;
  constexpr std::uint64_t launches = 20'000;
  const Ledger ledger = shine_on_sphere(
      scene, 60, launches, 6,
      [&](const Exit& exit, double r) {
        const std::size_t k = exit.meetings - 1;
        if (k >= orders) return;
        light[k] += exit.weight[0][0];
        const Order order = order_of(n, std::sqrt(1.0 - r * r), static_cast<int>(k) - 1);
        EXPECT_NEAR(-exit.direction.z, std::cos(order.scattering), 1e-9) << k << ", " << r;
        // Q in the scattering plane: that is the exit basis {s, p}; incoming light unpolarised.
        EXPECT_NEAR(exit.weight[0][1] / exit.weight[0][0],
                    (order.s - order.p) / (order.s + order.p), 1e-6)
            << k << ", " << r;
      },
      [&] {
        for (std::size_t i = 0; i < orders; ++i) means[i].add(light[i] / launches);
        light = {};
      });
  for (std::size_t k = 0; k < orders; ++k) {
    double expected = 0.0;
    constexpr int steps = 100'000;
    for (int i = 0; i < steps; ++i) {
      const double c = (i + 0.5) / steps;
      const Order o = order_of(n, c, static_cast<int>(k) - 1);
      expected += (o.s + o.p) * c / steps;  // 2c dc of the disc, half of s and of p
    }
    EXPECT_NEAR(means[k].value(), expected, sigmas * means[k].error()) << "order " << k;
    EXPECT_LT(means[k].error(), 0.002) << "of the light";
  }
  EXPECT_EQ(ledger.lost[0], 0.0);
}

TEST(WaterSphere, HasItsRainbowsAtTheirAngles) {
  Scene scene({0.4, 0.7});
  scene.periodic = false;
  const std::vector<double> n{1.343, 1.331};
  const MediumId drop = scene.add(Medium{n, {0.0, 0.0}});
  scene.spheres.push_back({Vec3(0.0, 0.0, 0.0), 1.0, scene.add(Interface{drop})});
  // Descartes: light of k reflections inside turns least where cos²θ = (n² - 1)/(k(k + 2)). The
  // primary bow (k = 1) is the least scattering angle of its order, the secondary the largest.
  const auto rainbow = [](double index, int k) {
    return optics::degrees(
        order_of(index, std::sqrt((index * index - 1.0) / (k * (k + 2.0))), k).scattering);
  };
  std::array<double, 2> least{180.0, 180.0};
  std::array<double, 2> largest{};
  const Ledger ledger = shine_on_sphere(
      scene, 5, 20'000, 7,
      [&](const Exit& exit, double) {
        const double angle = optics::degrees(std::acos(std::clamp(-exit.direction.z, -1.0, 1.0)));
        const std::size_t w = exit.wavelength;
        if (exit.meetings == 3) least[w] = std::min(least[w], angle);
        if (exit.meetings == 4) largest[w] = std::max(largest[w], angle);
      },
      [] {});
  for (std::size_t w = 0; w < 2; ++w) {
    EXPECT_NEAR(least[w], rainbow(n[w], 1), 0.01) << n[w];
    EXPECT_GE(least[w], rainbow(n[w], 1) - 1e-9) << "no light of this order is beyond its rainbow";
    EXPECT_NEAR(largest[w], rainbow(n[w], 2), 0.01) << n[w];
    EXPECT_LE(largest[w], rainbow(n[w], 2) + 1e-9);
    EXPECT_GT(least[w], 137.0);
    EXPECT_LT(least[w], 139.5);
    EXPECT_GT(order_of(n[w], std::sqrt((n[w] * n[w] - 1.0) / 3.0), 1).s,
              20.0 * order_of(n[w], std::sqrt((n[w] * n[w] - 1.0) / 3.0), 1).p)
        << "the primary bow is s polarised";
  }
  EXPECT_GT(least[0], least[1] + 1.0) << "violet scatters farther than red: it is inside the bow";
  EXPECT_LT(largest[0], largest[1]) << "the order of colours is reversed in the secondary bow";
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
      scene, theta, 200'000, 8, [&](const Exit& exit) { sum += exit.weight[0][0]; },
      [&] { mean.add(sum), sum = 0.0; });
  // κ itself changes the reflection at the face by less than 1e-4.
  EXPECT_NEAR(mean.value(), expected, sigmas * mean.error() + 1e-4);
  EXPECT_LT(mean.error(), 0.002 * mean.value());
}

}  // namespace
}  // namespace umov::trace
