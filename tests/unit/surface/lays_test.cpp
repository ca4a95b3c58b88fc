// Many lays of a described surface: errors that hold where its particles lie.
#include "host/surface/lays.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "host/errors/error.hpp"
#include "host/optics/angles.hpp"
#include "host/surface/mixture_run.hpp"
#include "tests/unit/surface/plain_spheres.hpp"

namespace umov::surface {
namespace {

using optics::radians;
using trace::Hemisphere;
using trace::Result;

ReadSurface scene(const std::string& text) {
  return [text](const Reading& reading) { return surface_from_toml(text, "scene.toml", reading); };
}

// So few particles that it matters where they lie.
const std::string few =
    "[surface]\nwavelengths_um = [0.5, 0.8]\nperiod_um = 200\n"
    "[substrate]\nmodel = \"lambertian\"\nrho = 0.1\n"
    "[[particles]]\nmaterial = \"clay\"\nradius_um = 20\ncoverage = 0.2\n"
    "layout = \"cluster\"\ncluster_size = 4\n"
    "[materials.clay]\nmodel = \"lambertian\"\nrho = [0.7, 0.3]\n";
const std::string rough =
    "[surface]\nwavelengths_um = 0.5\nperiod_um = 200\n"
    "[substrate]\nmodel = \"fresnel\"\nn = 1.5\nkappa = 1\nrough = { slope_rms = 0.5, "
    "correlation_um = 25 }\n";

std::string on_grid() {
  std::string grid = few;
  return grid.replace(grid.find("cluster\""), 8, "grid\"").erase(grid.find("cluster_size") - 1, 17);
}

Result run(const std::string& text, std::uint64_t seed, std::uint64_t samples,
           std::uint64_t launches, double theta_i_deg = 75.0) {
  trace::Request request;
  request.theta_i = radians(theta_i_deg);
  request.seed = seed;
  request.samples = samples;
  request.block = samples / 32;  // of one lay
  return Lays(scene(text), {.seed = seed}).simulate(Hemisphere(4, 0, 0.0), request, launches);
}

TEST(Lays, DifferAndHaveTheSameMaterials) {
  const Surface first = scene(few)({.seed = 7});
  const Surface again = scene(few)({.seed = lay_seed(7, 0)});
  const Surface second = scene(few)({.seed = lay_seed(7, 1), .like = &first});
  ASSERT_EQ(first.scene.spheres.size(), second.scene.spheres.size());
  EXPECT_EQ(first.scene.spheres[0].centre, again.scene.spheres[0].centre);
  EXPECT_NE(first.scene.spheres[0].centre, second.scene.spheres[0].centre);
  EXPECT_EQ(std::get<trace::Lambertian>(first.scene.materials[1]).albedo,
            std::get<trace::Lambertian>(second.scene.materials[1]).albedo);
  EXPECT_NE(lay_seed(7, 1), lay_seed(8, 1));
  EXPECT_NE(lay_seed(7, 1), lay_seed(7, 2));
}

TEST(Lays, AreManyWhereSomethingIsRandomAndLayingIsQuick) {
  const Surface random = scene(few)({});
  EXPECT_TRUE(random.random);
  EXPECT_EQ(launches_a_lay(random, 1'000'000), 4096u);
  EXPECT_EQ(launches_a_lay(random, 1600), 100u) << "sixteen lays in a short run";
  EXPECT_TRUE(scene(rough)({}).random);
  EXPECT_EQ(launches_a_lay(scene(on_grid())({}), 1'000'000), 0u);
  std::string fine = rough;
  fine.insert(fine.find("correlation_um"), "cells = 512, ");
  const Surface slow = scene(fine)({});
  EXPECT_EQ(launches_a_lay(slow, 500'000), 0u) << "half a million faces each";
  EXPECT_GT(launches_a_lay(slow, 1'000'000'000), 4096u);
}

TEST(Lays, ThatFindNoRoomAreLaidAnew) {
  // Crowded clusters, for whose last there is not always a place.
  std::string crowded = few;
  crowded.replace(crowded.find("coverage = 0.2"), 14, "coverage = 0.5");
  const ReadSurface read = scene(crowded);
  std::uint64_t seed = 1;
  const auto finds_room = [&](std::uint64_t s) {
    try {
      read({.seed = s});
      return true;
    } catch (const Error&) {
      return false;
    }
  };
  while (!finds_room(seed)) ++seed;
  int without = 0;
  for (std::uint64_t number = 1; number < 32; ++number) {
    if (!finds_room(lay_seed(seed, number))) ++without;
  }
  EXPECT_GT(without, 0) << "else this tests nothing";
  EXPECT_EQ(run(crowded, seed, 3200, 100).blocks(), 32u);
}

TEST(Lays, OfASurfaceWithoutAnythingRandomAreOne) {
  const std::string grid = on_grid();
  EXPECT_EQ(run(grid, 1, 6400, 200).state(), run(grid, 1, 6400, 0).state());
}

TEST(Lays, AreTheSameToTheLastBitForAnyNumberOfThreadsAndGoOnWhereTheyWereStopped) {
  const Lays lays(scene(few), {});
  trace::Request request;
  request.samples = 4800;
  request.threads = 1;
  const Hemisphere hemisphere(3, 0, 0.0);
  const auto alone = lays.simulate(hemisphere, request, 100).state();
  request.threads = 5;
  EXPECT_EQ(lays.simulate(hemisphere, request, 100).state(), alone);
  request.samples = 1600;
  const Result third = lays.simulate(hemisphere, request, 100);
  EXPECT_EQ(third.blocks(), 16u);
  request.samples = 4800;
  EXPECT_EQ(lays.simulate(hemisphere, request, 100, third.state()).state(), alone);
}

// Of values with errors, one a run with a seed of its own.
struct Scatter {
  double chi2 = 0.0;    // mean square deviation from the mean of all, in stated errors
  double within = 0.0;  // share that lies within two stated errors of it
};

Scatter scatter(const std::vector<trace::Estimate>& runs) {
  const double count = static_cast<double>(runs.size());
  double mean = 0.0;
  for (const trace::Estimate& e : runs) mean += e.mean / count;
  Scatter found;
  for (const trace::Estimate& e : runs) {
    const double z = (e.mean - mean) / e.error;
    found.chi2 += z * z / (count - 1.0);  // the mean is of the same runs
    if (std::abs(z) < 2.0) found.within += 1.0 / count;
  }
  return found;
}

std::vector<Result> runs(const std::string& text, std::uint64_t launches, double theta_i_deg) {
  std::vector<Result> all;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    all.push_back(run(text, seed, 32 * 400, launches, theta_i_deg));
  }
  return all;
}

trace::Estimate m00(const trace::MuellerEstimate& e) {
  return {e.mean[0][0], e.error[0][0]};
}

Scatter of_dhr(const std::vector<Result>& all) {
  std::vector<trace::Estimate> values;
  for (const Result& r : all) values.push_back(m00(r.hemispherical(0)));
  return scatter(values);
}

Scatter of_cells(const std::vector<Result>& all) {
  const std::size_t cells = all.front().hemisphere().cells();
  Scatter mean;
  for (std::size_t cell = 0; cell < cells; ++cell) {
    std::vector<trace::Estimate> values;
    for (const Result& r : all) values.push_back(m00(r.brdf(cell, 0)));
    const Scatter one = scatter(values);
    mean.chi2 += one.chi2 / static_cast<double>(cells);
    mean.within += one.within / static_cast<double>(cells);
  }
  return mean;
}

// With 32 lays a run χ² is 1.07; of 60 runs it scatters by .18.
TEST(Lays, HaveErrorsThatCoverWhereParticlesLie) {
  const auto many = runs(few, 400, 75.0);
  EXPECT_NEAR(of_dhr(many).chi2, 1.07, 0.55);
  EXPECT_GT(of_dhr(many).within, 0.86);
  EXPECT_NEAR(of_cells(many).chi2, 1.07, 0.3);
  EXPECT_NEAR(of_cells(many).within, 0.945, 0.03);
  EXPECT_GT(of_dhr(runs(few, 0, 75.0)).chi2, 4.0) << "errors of rays alone are too small";
}

TEST(Lays, HaveErrorsThatCoverHowRoughGroundRuns) {
  const auto many = runs(rough, 400, 40.0);
  EXPECT_NEAR(of_dhr(many).chi2, 1.07, 0.55);
  EXPECT_GT(of_dhr(many).within, 0.86);
  EXPECT_NEAR(of_cells(many).within, 0.93, 0.04);
  EXPECT_GT(of_dhr(runs(rough, 0, 40.0)).chi2, 4.0) << "errors of rays alone are too small";
}

TEST(Lays, AgreeWithAPlainTracerInEveryCell) {
  const std::string grains =
      "[surface]\nwavelengths_um = [0.5, 0.8]\nperiod_um = 400\n"
      "[substrate]\nmodel = \"lambertian\"\nrho = [0.05, 0.5]\n"
      "[[particles]]\nmaterial = \"clay\"\nradius_um = 20\ncoverage = 0.3\n"
      "[materials.clay]\nmodel = \"lambertian\"\nrho = [0.1, 0.9]\n";
  const Hemisphere cells(5, 0, 0.0);
  const formats::BrdfTable plain = PlainSpheres{400.0, 20.0, 0.3, {0.05, 0.5}, {0.1, 0.9}}.measured(
      cells, 60.0, {500.0, 800.0}, 64, 1500, 11);
  trace::Request request;
  request.theta_i = radians(60.0);
  request.samples = 1 << 18;
  const Result traced = Lays(scene(grains), {}).simulate(cells, request, 4096);
  ASSERT_EQ(plain.points.size(), 2 * cells.cells());
  double chi2 = 0.0;
  double dhr[2] = {0.0, 0.0};
  for (std::size_t i = 0; i < plain.points.size(); ++i) {
    const trace::Estimate e = m00(traced.brdf(i / 2, i % 2));
    const double z =
        (e.mean - plain.points.brdf_per_sr[i]) / std::hypot(e.error, plain.points.brdf_u[i]);
    chi2 += z * z / static_cast<double>(plain.points.size());
    dhr[i % 2] += plain.points.brdf_per_sr[i] * cells.cell(i / 2).projected;
  }
  EXPECT_NEAR(chi2, 1.0, 0.5);
  for (const std::size_t w : {0u, 1u}) {
    EXPECT_NEAR(m00(traced.hemispherical(w)).mean / dhr[w], 1.0, 0.015) << w;
  }
}

TEST(MixtureOfLays, HasALawWhoseErrorCoversWhereParticlesLie) {
  const auto law = [](std::uint64_t launches) {
    std::vector<trace::Estimate> gamma;
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
      MixtureRequest request;
      request.theta_i_deg = {75.0};
      request.coverage_factors = {0.5, 1.0};
      request.how.samples = 32 * 400;
      request.how.block = 400;
      request.how.seed = seed;
      request.rings = 1;
      request.strip = 0;
      request.launches = launches;
      const MixingLaw found = analyse_mixture(scene(few), request).at(0).law;
      gamma.push_back({found.gamma, found.gamma_u});
    }
    return scatter(gamma);
  };
  const Scatter many = law(400);
  EXPECT_NEAR(many.chi2, 1.07, 0.6);
  EXPECT_GT(many.within, 0.85);
  EXPECT_GT(law(0).chi2, 3.0) << "errors of rays alone are too small";
}

}  // namespace
}  // namespace umov::surface
