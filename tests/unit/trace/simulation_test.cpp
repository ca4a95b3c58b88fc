// The hemisphere of a scene: cells, errors, threads, reciprocity.
#include "host/trace/simulation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "host/brdf/evaluate.hpp"
#include "host/errors/error.hpp"
#include "host/trace/launch.hpp"
#include "tests/unit/team_of_threads.hpp"
#include "tests/unit/trace/over_cell.hpp"
#include "tests/unit/trace/scenes.hpp"

namespace umov::trace {
namespace {

using optics::element;
using optics::Mueller;
using optics::pi;
using optics::radians;

TEST(Hemisphere, CellsShareTheSolidAngleAndEveryDirectionHasItsCell) {
  for (const std::size_t rings : {1u, 2u, 18u, 45u}) {
    const Hemisphere hemisphere(rings, 180, radians(1.5));
    double projected = 0.0;
    for (std::size_t i = 0; i < hemisphere.cells(); ++i) {
      const Cell cell = hemisphere.cell(i);
      EXPECT_NEAR(cell.solid_angle, 2.0 * pi / static_cast<double>(hemisphere.cells()), 1e-12);
      projected += cell.projected;
      const double theta = 0.5 * (cell.theta_low + cell.theta_high);
      for (const double part : {0.01, 0.5, 0.99}) {
        const double phi = cell.phi_low + part * (cell.phi_high - cell.phi_low);
        EXPECT_EQ(hemisphere.find(optics::exit_direction(theta, phi)), i);
      }
    }
    EXPECT_NEAR(projected, pi, 1e-9);
    double strip = 0.0;
    for (std::size_t i = hemisphere.cells(); i < hemisphere.size(); ++i) {
      const Cell cell = hemisphere.cell(i);
      strip += cell.projected;
      const double theta = 0.5 * (cell.theta_low + cell.theta_high);
      EXPECT_EQ(hemisphere.find_in_strip(optics::exit_direction(theta, 0.0)), i);
    }
    EXPECT_NEAR(strip, 2.0 * (radians(1.5) + std::sin(radians(1.5)) * std::cos(radians(1.5))),
                1e-9);
    EXPECT_FALSE(hemisphere.find_in_strip(optics::exit_direction(0.5, 0.5)));
  }
  EXPECT_EQ(Hemisphere(18, 0, 0.0).cells(), 827u);
  EXPECT_THROW(Hemisphere(0, 0, 0.0), Error);
}

// A wet, dirty ground: everything that bounces.
Scene mixture() {
  Scene scene({0.45, 0.65});
  const MediumId wet = scene.add(Medium{{1.34, 1.33}, {0.0, 0.0}});
  const MaterialId skin = scene.add(Interface{wet});
  scene.add_plane(0.0, scene.add(Lambertian{{0.3, 0.5}}));
  scene.spheres.push_back({Vec3(0.25, 0.3, 0.2), 0.2, skin});
  scene.spheres.push_back({Vec3(0.65, 0.3, 0.1), 0.2, skin, 0.0});
  scene.spheres.push_back(
      {Vec3(0.3, 0.72, 0.2), 0.2, scene.add(Conductor{{1.2, 1.4}, {5.0, 6.0}})});
  scene.spheres.push_back({Vec3(0.7, 0.75, 0.2), 0.2, scene.add(Lambertian{{0.9, 0.4}})});
  return scene;
}

TEST(Simulation, IsTheSameToTheLastBitForAnyNumberOfThreads) {
  const Scene scene = mixture();
  const Geometry geometry(scene);
  const PathTracer tracer(scene, geometry);
  const Hemisphere hemisphere(6, 36, radians(3.0));
  Request request;
  request.theta_i = radians(40.0);
  request.samples = 8000;
  request.block = 250;
  request.threads = 1;
  const Result one = simulate(tracer, hemisphere, request);
  for (const int threads : {2, 5}) {
    request.threads = threads;
    const Result many = simulate(tracer, hemisphere, request);
    for (std::size_t cell = 0; cell < hemisphere.size(); ++cell) {
      for (std::size_t w = 0; w < 2; ++w) {
        ASSERT_EQ(one.brdf(cell, w).mean, many.brdf(cell, w).mean);
        ASSERT_EQ(one.brdf(cell, w).error, many.brdf(cell, w).error);
      }
    }
    EXPECT_EQ(one.hemispherical(0).mean, many.hemispherical(0).mean);
    EXPECT_EQ(one.ledger().rays, many.ledger().rays);
  }
  request.seed = 2;
  EXPECT_NE(one.hemispherical(0).mean, simulate(tracer, hemisphere, request).hemispherical(0).mean);
}

TEST(Simulation, GivesAModelledFaceItsModelInEveryCellAndElement) {
  const brdf::Model model = brdf::Model::by_name("microfacet+lambertian");
  const std::vector<double> values{1.5, 0.3, 0.3, 1.0, 0.2};
  ASSERT_EQ(model.parameters().size(), values.size());
  Scene scene({0.633});
  scene.add_plane(0.0, scene.add(Modelled{brdf::Sampler(model, values, 0.633)}));
  const Geometry geometry(scene);
  const PathTracer tracer(scene, geometry);
  const Hemisphere hemisphere(8, 0, 0.0);
  Request request;
  request.theta_i = radians(50.0);
  request.samples = 400'000;
  const Result result = simulate(tracer, hemisphere, request);
  double chi2 = 0.0;
  int count = 0;
  for (std::size_t cell = 0; cell < hemisphere.cells(); ++cell) {
    const Mueller<double> expected =
        over_cell(model, values, 0.633, request.theta_i, hemisphere.cell(cell), 8);
    const MuellerEstimate found = result.brdf(cell, 0);
    for (int i = 0; i < 16; ++i) {
      const double error = element(found.error, i / 4, i % 4);
      if (!(error > 1e-4 * expected[0][0])) continue;  // elements that are always 0
      const double z =
          (element(found.mean, i / 4, i % 4) - element(expected, i / 4, i % 4)) / error;
      chi2 += z * z;
      ++count;
      EXPECT_LT(std::abs(z), 5.5) << "cell " << cell << " element " << i / 4 << i % 4;
    }
  }
  EXPECT_GT(count, 1200);
  // Elements of a cell go together, so the scatter of this mean is wider than that of χ².
  EXPECT_NEAR(chi2 / count, 1.0, 0.15);
}

TEST(Simulation, ErrorsCoverTheTruthOfAWhiteGround) {
  Scene scene({0.5, 0.6});
  scene.add_plane(0.0, scene.add(Lambertian{{1.0, 0.25}}));
  const Geometry geometry(scene);
  const PathTracer tracer(scene, geometry);
  const Hemisphere hemisphere(18, 90, radians(2.0));
  Request request;
  request.samples = 200'000;
  const Result result = simulate(tracer, hemisphere, request);
  EXPECT_NEAR(result.hemispherical(0).mean[0][0], 1.0, 1e-12);
  EXPECT_NEAR(result.hemispherical(1).mean[0][0], 0.25, 1e-12);
  double chi2 = 0.0;
  int beyond = 0;
  for (std::size_t cell = 0; cell < hemisphere.cells(); ++cell) {
    const MuellerEstimate e = result.brdf(cell, 1);
    const double z = (e.mean[0][0] - 0.25 / pi) / e.error[0][0];
    chi2 += z * z;
    beyond += std::abs(z) > 1.96 ? 1 : 0;
  }
  const double n = static_cast<double>(hemisphere.cells());
  // 4 σ of a binomial; small cells see few exits, whose distribution has tails.
  EXPECT_NEAR(beyond / n, 0.05, 4.0 * std::sqrt(0.05 * 0.95 / n) + 0.01);
  EXPECT_NEAR(chi2 / n, 1.0, 0.25);
}

TEST(Simulation, IsTheSameToTheLastBitForAnyNumberOfRanks) {
  const Scene scene = mixture();
  const Geometry geometry(scene);
  const PathTracer tracer(scene, geometry);
  const Hemisphere hemisphere(4, 12, radians(3.0));
  Request request;
  request.theta_i = radians(40.0);
  request.samples = 12000;
  request.block = 250;
  request.threads = 1;
  request.emissivity = true;
  const std::vector<double> alone = simulate(tracer, hemisphere, request).state();
  for (const std::size_t ranks : {2u, 3u, 4u, 17u}) {
    std::vector<std::vector<double>> states(ranks);
    as_team(ranks, [&](const TeamOfThreads& member) {
      Request own = request;
      own.team = &member;
      states[member.rank()] = simulate(tracer, hemisphere, own).state();
    });
    for (const auto& state : states) EXPECT_EQ(state, alone) << ranks << " ranks";
  }
  // One rank that is asked to stop ends the run of all, after the same blocks.
  std::vector<std::uint64_t> samples(2);
  as_team(2, [&](const TeamOfThreads& member) {
    Request own = request;
    own.team = &member;
    own.stop = [&member] { return member.rank() == 1; };
    samples[member.rank()] = simulate(tracer, hemisphere, own).samples();
  });
  EXPECT_EQ(samples[0], 8000u);
  EXPECT_EQ(samples[1], 8000u);
}

TEST(Simulation, GoesOnWhereItWasStoppedToTheLastBit) {
  const Scene scene = mixture();
  const Geometry geometry(scene);
  const PathTracer tracer(scene, geometry);
  const Hemisphere hemisphere(4, 0, 0.0);
  Request request;
  request.samples = 12000;
  request.block = 250;
  request.emissivity = true;
  const std::vector<double> whole = simulate(tracer, hemisphere, request).state();
  Request stopped = request;
  stopped.stop = [] { return true; };
  const Result half = simulate(tracer, hemisphere, stopped);
  EXPECT_EQ(half.samples(), 8000u);
  EXPECT_EQ(simulate(tracer, hemisphere, request, half.state()).state(), whole);
  EXPECT_THROW(simulate(tracer, Hemisphere(3, 0, 0.0), request, half.state()), Error);
  request.rays = half.ledger().rays;
  EXPECT_EQ(simulate(tracer, hemisphere, request).samples(), 8000u) << "as many rays";
}

TEST(Simulation, HasBlocksThatFitItsSceneAndKeepsThoseItWasBegunWith) {
  Scene rough({0.5});
  rough.add_height_field(64, 64, std::vector<double>(64 * 64, 0.0), rough.add(Lambertian{{0.5}}));
  EXPECT_GE(rough.faces(), 8192u);
  Request request;
  request.samples = 10'000'000;
  EXPECT_EQ(block_of(request, rough), rough.faces());
  request.samples = 500'000;
  EXPECT_EQ(block_of(request, rough), 500'000u / 128);
  request.samples = 1000;
  EXPECT_EQ(block_of(request, rough), 2048u);
  request.samples = 10'000'000;
  request.rays = 100;
  EXPECT_EQ(block_of(request, rough), 2048u);
  request.rays = 0;
  request.samples = 300'000;
  const Geometry geometry(rough);
  const PathTracer tracer(rough, geometry);
  const Hemisphere hemisphere(1, 0, 0.0);
  const Result begun = simulate(tracer, hemisphere, request);
  EXPECT_EQ(begun.samples() / begun.blocks(), 300'000u / 128);
  request.samples = 500'000;
  const Result more = simulate(tracer, hemisphere, request, begun.state());
  EXPECT_EQ(more.samples() / more.blocks(), 300'000u / 128);
  EXPECT_GE(more.samples(), 500'000u);
  EXPECT_NEAR(more.hemispherical(0).mean[0][0], 0.5, 1e-12);
}

TEST(Simulation, StopsAtTheErrorAskedFor) {
  const Scene scene = mixture();
  const Geometry geometry(scene);
  const PathTracer tracer(scene, geometry);
  Request request;
  request.block = 256;
  request.samples = 10'000'000;
  request.dhr_relative_error = 0.01;
  int reports = 0;
  request.progress = [&](const Progress& p) {
    ++reports;
    EXPECT_EQ(p.samples, static_cast<std::uint64_t>(reports) * 16 * 256);
  };
  const Result result = simulate(tracer, Hemisphere(3, 0, 0.0), request);
  EXPECT_LT(result.samples(), 100'000u);
  EXPECT_LE(result.hemispherical(0).error[0][0], 0.01 * result.hemispherical(0).mean[0][0]);
  const Estimate dop = result.hemispherical_dop(0);
  EXPECT_GT(dop.error, 0.0);
  EXPECT_LT(std::abs(dop.mean), 0.2);
  request.theta_i = 0.5 * pi;
  EXPECT_THROW(simulate(tracer, Hemisphere(3, 0, 0.0), request), Error);
}

TEST(Simulation, StopsAtTheErrorOfCellsAskedFor) {
  const Scene scene = mixture();
  const Geometry geometry(scene);
  const PathTracer tracer(scene, geometry);
  const Hemisphere hemisphere(3, 0, 0.0);
  Request request;
  request.block = 256;
  request.samples = 10'000'000;
  request.cells.relative_error = 0.03;
  const auto shares_known = [&](const Result& result) {
    double least = 1.0;
    for (std::size_t w = 0; w < 2; ++w) {
      double known = 0.0;
      for (std::size_t cell = 0; cell < hemisphere.cells(); ++cell) {
        const MuellerEstimate e = result.brdf(cell, w);
        if (e.error[0][0] <= 0.03 * e.mean[0][0]) known += 1.0;
      }
      least = std::min(least, known / static_cast<double>(hemisphere.cells()));
    }
    return least;
  };
  const Result median = simulate(tracer, hemisphere, request);
  EXPECT_GE(shares_known(median), 0.5);
  EXPECT_LT(shares_known(median), 1.0);
  request.cells.percentile = 100.0;
  double done = 0.0;
  request.progress = [&](const Progress& p) {
    EXPECT_GE(p.done, 0.5 * done) << "errors fall as the root of the launches";
    done = p.done;
  };
  const Result all = simulate(tracer, hemisphere, request);
  EXPECT_EQ(shares_known(all), 1.0);
  EXPECT_GT(all.samples(), median.samples());
  EXPECT_EQ(done, 1.0);
  request.progress = {};
  request.cells.cell = 0;
  const Result one = simulate(tracer, hemisphere, request);
  EXPECT_LT(one.samples(), all.samples());
  EXPECT_LE(one.brdf(0, 0).error[0][0], 0.03 * one.brdf(0, 0).mean[0][0]);
  // Both goals must be met.
  request.dhr_relative_error = 0.5 * one.dhr_relative_error();
  EXPECT_GT(simulate(tracer, hemisphere, request).samples(), 2 * one.samples());
  request.cells.cell = hemisphere.cells();
  EXPECT_THROW(simulate(tracer, hemisphere, request), Error);
  request.cells = {0.03, 0.0, {}};
  EXPECT_THROW(simulate(tracer, hemisphere, request), Error);
}

// Directions between two polar angles and two azimuths.
struct Bundle {
  double theta_low, theta_high, phi_low, phi_high;  // degrees

  double sine2(double degrees) const { return std::pow(std::sin(radians(degrees)), 2); }
  double projected() const {
    return 0.5 * radians(phi_high - phi_low) * (sine2(theta_high) - sine2(theta_low));
  }
  Vec3 draw(double u, double v) const {
    const double theta =
        std::asin(std::sqrt(sine2(theta_low) + u * (sine2(theta_high) - sine2(theta_low))));
    return optics::exit_direction(theta, radians(phi_low + v * (phi_high - phi_low)));
  }
  bool holds(const Vec3& d) const {
    const double theta = optics::degrees(std::acos(d.z));
    const double phi = optics::degrees(std::atan2(d.y, d.x));
    return theta > theta_low && theta < theta_high && phi > phi_low && phi < phi_high;
  }
};

TEST(Reciprocity, HoldsForEveryElementOfASceneWithoutSymmetry) {
  // ∬ f cos θi cos θr over two bundles, light going from one to the other and back. Reversing a
  // beam turns s and k round: U changes sign. Known to .2 %.
  const Bundle here{0.0, 65.0, 0.0, 180.0};
  const Bundle there{10.0, 85.0, -180.0, 0.0};
  const Scene scene = mixture();
  const Geometry geometry(scene);
  const PathTracer tracer(scene, geometry);
  PathTracer::Workspace workspace(tracer);
  constexpr std::uint64_t blocks = 64;
  constexpr std::uint64_t launches = 16'000;
  const auto transport = [&](const Bundle& from, const Bundle& to, std::uint64_t seed) {
    std::array<test::Mean, 16> means;
    Mueller<double> sum(0.0);
    Ledger ledger(2);
    test::Each collector([&](const Exit& exit) {
      if (exit.wavelength == 1 && exit.direction.z > 0.0 && to.holds(exit.direction)) {
        sum += exit.weight;
      }
    });
    for (std::uint64_t block = 0; block < blocks; ++block) {
      for (std::uint64_t i = 0; i < launches; ++i) {
        const std::uint64_t sample = block * launches + i;
        const auto u = uniforms(seed, sample, 0);
        const auto v = uniforms(seed + 100, sample, 0);
        const auto at = launch_point(i, launches, u);
        tracer.trace(Vec3(at[0], at[1], geometry.top() + 0.01),
                     optics::beam_along(-from.draw(v[0], v[1])), seed, sample, workspace, collector,
                     ledger);
      }
      for (int e = 0; e < 16; ++e) {
        means[static_cast<std::size_t>(e)].add(element(sum, e / 4, e % 4) * from.projected() /
                                               static_cast<double>(launches));
      }
      sum = Mueller<double>(0.0);
    }
    return means;
  };
  const auto forth = transport(here, there, 21);
  const auto back = transport(there, here, 22);
  const double sign[4] = {1, 1, -1, 1};
  double polarised = 0.0;
  for (std::size_t r = 0; r < 4; ++r) {
    for (std::size_t c = 0; c < 4; ++c) {
      const test::Mean& a = forth[4 * r + c];
      const test::Mean& b = back[4 * c + r];
      EXPECT_NEAR(a.value(), sign[r] * sign[c] * b.value(), 3.0 * std::hypot(a.error(), b.error()))
          << "element " << r << c;
      EXPECT_LT(std::hypot(a.error(), b.error()), 0.002 * forth[0].value());
      if (r + c > 0) polarised = std::max(polarised, std::abs(a.value()) / a.error());
    }
  }
  EXPECT_GT(polarised, 10.0) << "the scene must polarise for this to mean something";
}

}  // namespace
}  // namespace umov::trace
