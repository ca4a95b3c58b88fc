// What the tracer must find where the answer is known without it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "host/chamber/camera.hpp"
#include "host/chamber/goniophotometer.hpp"
#include "host/chamber/mixing_chamber.hpp"
#include "host/chamber/radiosity.hpp"
#include "host/chamber/synthetic_mcpet.hpp"
#include "host/trace/random_stream.hpp"
#include "tests/unit/chamber/chambers.hpp"
#include "tests/unit/team_of_threads.hpp"

namespace umov::chamber {
namespace {

using optics::pi;

struct Mean {
  double value, error;
};

/// Of `paths` looks from a point along a direction.
Mean seen(const Tracer& tracer, const Vec3& origin, const Vec3& direction, int paths,
          Estimator estimator = Estimator::mis) {
  double sum = 0.0;
  double squares = 0.0;
  Work work;
  for (int i = 0; i < paths; ++i) {
    const double l =
        tracer.luminance(origin, direction, estimator, 7, static_cast<std::uint64_t>(i), work);
    sum += l;
    squares += l * l;
  }
  const double mean = sum / paths;
  return {mean, std::sqrt(std::max(0.0, squares / paths - mean * mean) / (paths - 1.0))};
}

// A small source on the wall lights all of it alike; so does every other spot of the wall.
TEST(IntegratingSphere, IsAsBrightAsTheMultiplierSays) {
  constexpr double radius = 100.0;
  constexpr double rho = 0.9;
  constexpr double port_z = -95.0;  // the cap below is left out
  Luminaire l;
  const auto wall = l.add(matt(rho), true);
  l.scene.spheres.push_back({Vec3(0, 0, 0), radius, wall, port_z});
  const double small = 0.5;
  l.add_emitter(disc(0, 0, radius - 0.01, small, 100.0, false), matt(rho));
  const Tracer tracer(l);
  const double port = 0.5 * (1.0 + port_z / radius);
  const double irradiance = 1e6 * 100.0 / (4.0 * pi * radius * radius) / (1.0 - rho * (1.0 - port));
  const double expected = rho * irradiance / pi;
  for (const Vec3& along : {Vec3(1, 0, 0), Vec3(0.6, 0.0, 0.8), Vec3(0.0, 0.8, -0.6)}) {
    const Mean m = seen(tracer, Vec3(0, 0, 0), along, 40'000);
    EXPECT_NEAR(m.value, expected, 3.0 * m.error + 1e-4 * expected);
    EXPECT_LT(m.error, 0.01 * expected);
  }
  const Distribution d = intensity_distribution(tracer, {.rays = 200'000});
  const double everywhere = irradiance * 4.0 * pi * radius * radius * 1e-6;
  EXPECT_NEAR(d.out_lm, port * everywhere, 3.0 * d.out_se);
  EXPECT_NEAR(d.fate.absorbed, (1.0 - port) * (1.0 - rho) * everywhere, 3.0 * d.out_se);
}

// Walls that all shine alike and reflect alike: Le/(1 - ρ) everywhere.
TEST(ClosedFurnace, IsEvenWhateverTheWallsDo) {
  const auto half = std::make_shared<Surface>("half", Lambertian{0.5});
  const auto mixed =
      std::make_shared<Surface>("mixed", DiffuseSpecular{0.5, {0.0, 80.0}, {0.3, 0.3}});
  for (const auto& surface :
       {std::shared_ptr<const Surface>(half), std::shared_ptr<const Surface>(mixed)}) {
    Luminaire l;
    const auto side = [&](const Vec3& centre, const Vec3& u, const Vec3& v) {
      Emitter e{};
      e.flux_lm = 4.0 * std::sqrt(optics::dot(u, u) * optics::dot(v, v)) * 1e-6 * pi * 1000.0;
      e.centre = centre;
      e.half_u = u;
      e.half_v = v;
      const Vec3 n = optics::cross(u, v);
      e.normal = n / std::sqrt(optics::dot(n, n));
      l.add_emitter(e, surface);
    };
    const Vec3 x(10, 0, 0);
    const Vec3 y(0, 15, 0);
    const Vec3 z(0, 0, 20);
    side(-x, y, z);
    side(x, z, y);
    side(-y, z, x);
    side(y, x, z);
    side(-z, x, y);
    side(z, y, x);
    const Tracer tracer(l);
    for (const Estimator e : {Estimator::unidirectional, Estimator::next_event, Estimator::mis}) {
      const Mean m = seen(tracer, Vec3(1, 2, 3), Vec3(0.48, 0.6, 0.64), 20'000, e);
      EXPECT_NEAR(m.value, 2000.0, 3.0 * m.error + 1e-9) << static_cast<int>(e);
    }
  }
}

TEST(PathsWithoutEnd, AreGivenUpAndCounted) {
  Luminaire l;
  const auto all = matt(1.0);
  l.scene.tubes.push_back({0, 0, 10.0, 0.0, 5.0, true, l.add(all)});
  l.scene.plates.push_back({0, 0, 5.0, 10.0, false, l.add(all)});
  l.add_emitter(disc(0, 0, 0, 10.0, 1.0), all);
  const Tracer tracer(l);
  Work work;
  const double seen = tracer.luminance(Vec3(0, 0, 2), Vec3(1, 0, 0), Estimator::mis, 1, 0, work);
  EXPECT_EQ(work.endless, 1U);
  EXPECT_GT(seen, 0.0);
  Fate fate = tracer.empty_fate();
  EXPECT_FALSE(tracer.launch(1.0, {}, 1, 0, fate).has_value());
  EXPECT_EQ(fate.lost, 1.0);
}

TEST(ViewFactors, OfADiscToTheDiscAndTheWallThatCloseItsTube) {
  constexpr double radius = 20.0;
  constexpr double height = 30.0;
  Luminaire l;
  const auto wall = l.add(matt(0.0));
  const auto lid = l.add(matt(0.0));
  l.scene.tubes.push_back({0, 0, radius, 0.0, height, true, wall});
  l.scene.plates.push_back({0, 0, height, radius, false, lid});
  const double small = 15.0;
  l.add_emitter(disc(0, 0, 0, small, 1.0), matt(0.0));
  const Tracer tracer(l);
  const Distribution d = intensity_distribution(tracer, {.rays = 1'500'000});
  const double r1 = small / height;
  const double r2 = radius / height;
  const double s = 1.0 + (1.0 + r2 * r2) / (r1 * r1);
  const double to_lid = 0.5 * (s - std::sqrt(s * s - 4.0 * (r2 / r1) * (r2 / r1)));
  EXPECT_NEAR(d.fate.incident[lid], to_lid, 1e-3);
  EXPECT_NEAR(d.fate.incident[wall], 1.0 - to_lid, 1e-3);
  EXPECT_EQ(d.fate.out, 0.0);
  EXPECT_EQ(d.fate.behind, 0.0);
}

TEST(LambertianDisc, HasTheIntensityOfTheCosine) {
  Luminaire l;
  l.add_emitter(disc(0, 0, 0, 5.0, pi), matt(0.0));
  const Tracer tracer(l);
  const Distribution d = intensity_distribution(tracer, {.rays = 400'000, .planes = 4});
  int outside = 0;
  for (std::size_t g = 0; g < 18; ++g) {
    for (std::size_t c = 0; c < 4; ++c) {
      // A cell's mean of the cosine over its solid angle.
      const double step = optics::radians(2.5);
      const double gamma = optics::radians(d.gamma_deg[g]);
      const double a = std::max(0.0, gamma - step);
      const double b = gamma + step;
      const double mean =
          0.5 * (std::pow(std::sin(b), 2) - std::pow(std::sin(a), 2)) / (std::cos(a) - std::cos(b));
      const double off = std::abs(d.intensity(c, g) - mean) / d.intensity_se[c * 37 + g];
      EXPECT_LT(off, 5.0) << c << " " << g;
      outside += off > 2.0 ? 1 : 0;
    }
  }
  EXPECT_LT(outside, 10);  // of 72; 3 to 4 are expected
  EXPECT_NEAR(d.efficiency(), 1.0, 1e-12);
  EXPECT_NEAR(d.photometry().zonal_lm(0.0, 90.0), pi, 0.02);
}

/// A rectangle about a centre whose coordinates no single-precision number has.
Emitter rectangle(const Vec3& centre, const Vec3& half_u, const Vec3& half_v) {
  Emitter e{};
  e.name = "rectangle";
  e.flux_lm = 1.0;
  e.centre = centre;
  const Vec3 normal = optics::cross(half_u, half_v);
  e.normal = normal / std::sqrt(optics::dot(normal, normal));
  e.half_u = half_u;
  e.half_v = half_v;
  e.disc = false;
  return e;
}

TEST(Rectangles, SendAllTheirLightWhereverTheyStand) {
  const Vec3 tilted_u(3.1, 0.7, 0.4), tilted_v(-0.7, 3.1, 0.0);
  for (const Vec3& centre : {Vec3(0.0, 0.0, 0.1), Vec3(33.3, -7.7, 5.4), Vec3(0.3, 0.2, -0.6)}) {
    for (const auto& [u, v] : {std::pair{Vec3(2.0, 0.0, 0.0), Vec3(0.0, 1.0, 0.0)},
                               {Vec3(0.0, 1.0, 0.0), Vec3(2.0, 0.0, 0.0)},
                               {tilted_u, tilted_v}}) {
      Luminaire l;
      l.add_emitter(rectangle(centre, u, v), matt(0.0));
      const Tracer tracer(l);
      const Distribution d = intensity_distribution(tracer, {.rays = 20'000, .planes = 4});
      EXPECT_NEAR(d.efficiency(), 1.0, 1e-12) << centre.x << " " << centre.z;
      EXPECT_EQ(d.fate.behind, 0.0);
    }
  }
}

TEST(Rectangles, AreFoundByShadowRaysFromClose) {
  // A matt plate under a face of .1 mm above: the plate's brightness by next event alone is that
  // by chance.
  Luminaire l;
  l.add_emitter(rectangle(Vec3(40.3, 0.0, 0.1), Vec3(0.0, 8.0, 0.0), Vec3(8.0, 0.0, 0.0)),
                matt(0.0));
  const trace::MaterialId plate = l.add(matt(0.5));
  l.scene.plates.push_back({40.3, 0.0, 0.0, 20.0, true, plate});
  const Tracer tracer(l);
  const Vec3 down = Vec3(-1.0, 0.0, -0.006) / std::sqrt(1.0 + 0.006 * 0.006);
  const Vec3 eye = Vec3(40.3, 0.0, 0.0) - 9.5 * down;
  const Mean by_events = seen(tracer, eye, down, 20'000, Estimator::next_event);
  const Mean by_chance = seen(tracer, eye, down, 20'000, Estimator::unidirectional);
  EXPECT_GT(by_chance.value, 0.0);
  EXPECT_NEAR(by_events.value, by_chance.value, 4.0 * std::hypot(by_events.error, by_chance.error));
}

TEST(DiffuseChamber, AgreesWithRadiosityInEveryZone) {
  const Zones zones{
      {0.0, 5.0, 10.0, 16.0, PaperChamber::height}, {0.0, 12.0, PaperChamber::radius}, 5, 72};
  const PaperChamber chamber(matt(0.984), 0.5, zones.wall_mm, zones.base_mm);
  const Tracer tracer(chamber.luminaire);
  const Distribution d = intensity_distribution(tracer, {.rays = 2'000'000});
  DiffuseChamber same{PaperChamber::radius, PaperChamber::height, 0.984, 0.984, {}};
  for (int k = 0; k < 4; ++k) {
    const double a = optics::radians(90.0 * k);
    same.holes.push_back({PaperChamber::ring * std::cos(a), PaperChamber::ring * std::sin(a),
                          PaperChamber::hole, 0.5, PaperChamber::flux_lm});
  }
  const Radiosity r = solve_radiosity(same, zones);
  for (std::size_t i = 0; i < chamber.wall.size(); ++i) {
    const double area = 2.0 * pi * PaperChamber::radius * (zones.wall_mm[i + 1] - zones.wall_mm[i]);
    const double lx = 1e6 * d.fate.incident[chamber.wall[i]] / area;
    EXPECT_NEAR(lx / r.wall_lx[i], 1.0, 0.005) << "wall " << i;
  }
  for (std::size_t i = 0; i < chamber.base.size(); ++i) {
    double area = pi * (std::pow(zones.base_mm[i + 1], 2) - std::pow(zones.base_mm[i], 2));
    if (i == 0) area -= 4.0 * pi * std::pow(PaperChamber::hole, 2);
    const double lx = 1e6 * d.fate.incident[chamber.base[i]] / area;
    EXPECT_NEAR(lx / r.base_lx[i], 1.0, 0.005) << "base " << i;
  }
  EXPECT_NEAR(d.out_lm, r.out_lm, 3.0 * d.out_se + 0.002 * r.out_lm);
  EXPECT_NEAR(d.first_hit_fraction * d.source_lm, r.first_hit_lm, 0.003 * r.first_hit_lm);
  // Energy: every material takes its share of what it gets; black edges take all.
  for (std::size_t m = 0; m < d.fate.incident.size(); ++m) {
    if (!(d.fate.incident[m] > 0.0)) continue;
    const bool black = chamber.luminaire.surfaces[m]->black();
    const double share = black ? 1.0 : 1.0 - 0.984;
    EXPECT_NEAR(d.fate.taken[m] / d.fate.incident[m], share, 0.01 * share) << m;
  }
  EXPECT_EQ(d.fate.behind, 0.0);
  EXPECT_EQ(d.fate.lost, 0.0);
  // And nothing comes or goes but through the opening and into faces.
  EXPECT_NEAR((d.fate.out + d.fate.absorbed) / d.fate.launched, 1.0, 1e-4);
}

std::shared_ptr<const Surface> tabulated(double total) {
  return std::make_shared<const Surface>(
      "table", PlanesSurface(synthetic_mcpet(mcpet_theta_i_deg, 2.5), 0, total));
}

TEST(TabulatedChamber, TakesWhatItsTableDoesNotReflect) {
  MixingChamber chamber;
  chamber.wall = tabulated(0.7);
  const Luminaire l = chamber.luminaire();
  const Tracer tracer(l);
  const Distribution d = intensity_distribution(tracer, {.rays = 400'000});
  int walls = 0;
  for (std::size_t m = 0; m < d.fate.incident.size(); ++m) {
    if (l.surfaces[m] != chamber.wall || !(d.fate.incident[m] > 0.0)) continue;
    EXPECT_NEAR(d.fate.taken[m] / d.fate.incident[m], 0.3, 0.003) << m;
    ++walls;
  }
  EXPECT_EQ(walls, 2);  // side and base
}

// Values and densities of the wall, points on sources and the file's luminance fit together.
TEST(TabulatedChamber, LooksAlikeToAllEstimatorsUnderAPhotometricFile) {
  MixingChamber chamber;
  chamber.wall = tabulated(0.8);
  chamber.depth_mm = 0.0;
  Luminaire l = chamber.luminaire();
  const auto table = std::make_shared<const IntensityTable>(
      formats::parse_photometry(
          "IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 4 1 1 2 0 0 0\n1 1 10\n0 30 60 90\n0\n"
          "100 80 60 20\n",
          "spot.ies"),
      "spot.ies");
  for (Emitter& emitter : l.emitters) emitter.table = table;
  const Tracer tracer(l);
  for (const double height : {4.0, 12.0}) {
    const Vec3 along = Vec3(0.9, 0.1, -0.8) / std::sqrt(0.81 + 0.01 + 0.64);
    const Vec3 origin(0.0, 0.0, height + 19.0);
    const Mean mis = seen(tracer, origin, along, 40'000);
    EXPECT_LT(mis.error, 0.015 * mis.value);
    for (const Estimator e : {Estimator::unidirectional, Estimator::next_event}) {
      const Mean other = seen(tracer, origin, along, 60'000, e);
      EXPECT_LT(other.error, 0.04 * mis.value);
      EXPECT_NEAR(other.value, mis.value, 4.0 * std::hypot(other.error, mis.error))
          << static_cast<int>(e) << " at " << height;
    }
  }
}

TEST(Distribution, FewRaysComeFromAllSources) {
  Luminaire l;
  l.add_emitter(disc(0, 0, 1, 5.0, 1.0), matt(0.0));
  l.add_emitter(disc(0, 0, -1, 5.0, 1.0, false), matt(0.0));
  const Tracer tracer(l);
  const Distribution d = intensity_distribution(tracer, {.rays = 64, .planes = 1, .angles = 3});
  ASSERT_EQ(d.rays_launched, 64U);
  // Cells reach 45° from the poles, where half of a disc's light goes; the one between has both.
  const double cap = 2.0 * pi * (1.0 - std::cos(optics::radians(45.0)));
  const double up = d.intensity(0, 0) * cap;
  const double down = d.intensity(0, 2) * cap;
  EXPECT_NEAR(up, 0.5, 0.44);  // 16 ± 3.5 of 64 rays of 1/32 lm
  EXPECT_NEAR(down, 0.5, 0.44);
  EXPECT_NEAR(d.out_lm, 2.0, 1e-9);
}

TEST(Distribution, DoesNotDependOnThreadsAndRanks) {
  const PaperChamber chamber(matt(0.984), 1.0, {0.0, PaperChamber::height},
                             {0.0, PaperChamber::radius});
  const Tracer tracer(chamber.luminaire);
  DistributionRequest request{.rays = 20'000, .planes = 8, .angles = 19};
  request.threads = 1;
  const Distribution one = intensity_distribution(tracer, request);
  request.threads = 3;
  EXPECT_EQ(intensity_distribution(tracer, request).intensity_cd, one.intensity_cd);
  for (const std::size_t ranks : {2u, 3u, 70u}) {  // there are 64 blocks
    as_team(ranks, [&](const TeamOfThreads& member) {
      DistributionRequest own = request;
      own.threads = 1;
      own.team = &member;
      const Distribution d = intensity_distribution(tracer, own);
      EXPECT_EQ(d.intensity_cd, one.intensity_cd) << member.rank() << " of " << ranks;
      EXPECT_EQ(d.intensity_se, one.intensity_se);
      EXPECT_EQ(d.fate.numbers(), one.fate.numbers());
      EXPECT_EQ(d.out_se, one.out_se);
    });
  }
}

TEST(Map, DoesNotDependOnThreadsAndRanks) {
  const PaperChamber chamber(matt(0.984), 1.0, {0.0, PaperChamber::height},
                             {0.0, PaperChamber::radius});
  const Tracer tracer(chamber.luminaire);
  Camera camera;
  camera.centre = Vec3(0, 0, PaperChamber::height);
  camera.width = 24;
  camera.height = 10;
  camera.pixel_mm = 2.0;
  MapRequest request;
  request.rays_per_pixel = 20;
  request.threads = 1;
  const Map one = luminance_map(tracer, camera, request);
  request.threads = 3;
  const Map three = luminance_map(tracer, camera, request);
  EXPECT_EQ(one.luminance_cd_m2, three.luminance_cd_m2);
  EXPECT_EQ(one.luminance_se, three.luminance_se);
  for (const std::size_t ranks : {2u, 3u, 4u}) {
    as_team(ranks, [&](const TeamOfThreads& member) {
      MapRequest own = request;
      own.threads = 1;
      own.team = &member;
      const Map map = luminance_map(tracer, camera, own);
      EXPECT_EQ(map.luminance_cd_m2, one.luminance_cd_m2) << member.rank() << " of " << ranks;
      EXPECT_EQ(map.luminance_se, one.luminance_se);
      EXPECT_EQ(map.work.rays, one.work.rays);
    });
  }
  request.seed = 2;
  EXPECT_NE(one.luminance_cd_m2, luminance_map(tracer, camera, request).luminance_cd_m2);
}

}  // namespace
}  // namespace umov::chamber
