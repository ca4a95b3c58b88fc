// Figures of merit on maps whose figures are known.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "host/chamber/figures.hpp"
#include "host/chamber/map_picture.hpp"
#include "host/chamber/result_file.hpp"
#include "host/chamber/synthetic_mcpet.hpp"
#include "host/formats/image_file.hpp"
#include "tests/unit/chamber/chambers.hpp"
#include "tests/unit/failure.hpp"

namespace umov::chamber {
namespace {

Map map_of(std::size_t width, std::size_t height, const auto& value) {
  Map map;
  map.width = width;
  map.height = height;
  map.pixel_mm = 0.5;
  map.rays_per_pixel = 10;
  for (std::size_t y = 0; y < height; ++y) {
    for (std::size_t x = 0; x < width; ++x) {
      map.luminance_cd_m2.push_back(value(static_cast<double>(x), static_cast<double>(y)));
      map.luminance_se.push_back(0.5);
    }
  }
  return map;
}

double hill(double x, double y) {
  return 100.0 + 300.0 * std::exp(-((x - 20.3) * (x - 20.3) + (y - 14.0) * (y - 14.0)) / 50.0);
}

TEST(Likeness, TellsShapeFromSize) {
  const Map a = map_of(40, 30, hill);
  const Map twice = map_of(40, 30, [](double x, double y) { return 2.0 * hill(x, y); });
  const Likeness same = likeness(a, a);
  EXPECT_NEAR(same.ncc, 1.0, 1e-12);
  EXPECT_EQ(same.nrmse, 0.0);
  const Likeness l = likeness(a, twice);
  EXPECT_NEAR(l.ncc, 1.0, 1e-12);
  double squares = 0.0, sum = 0.0, largest = 0.0;
  for (const double v : a.luminance_cd_m2) {
    squares += v * v;
    sum += v;
    largest = std::max(largest, 2.0 * v);
  }
  EXPECT_NEAR(l.nrmse, std::sqrt(squares / 1200.0) / largest, 1e-12);
  EXPECT_NEAR(l.mean_deviation, sum / 1200.0 / largest, 1e-12);
  const Map upside_down = map_of(40, 30, [](double x, double y) { return 500.0 - hill(x, y); });
  EXPECT_NEAR(likeness(a, upside_down).ncc, -1.0, 1e-12);
  EXPECT_NE(failure_of([&] { likeness(a, map_of(4, 30, hill)); }).find("same camera"),
            std::string::npos);
}

TEST(Registration, FindsAMoveOfPartsOfAPixel) {
  const Map a = map_of(40, 30, hill);
  const Map b = map_of(40, 30, [](double x, double y) { return hill(x + 1.7, y - 0.6); });
  EXPECT_LT(likeness(a, b).ncc, 0.99);
  const Registration r = registered(a, b, 4.0);
  EXPECT_NEAR(r.x_pixels, 1.7, 0.15);
  EXPECT_NEAR(r.y_pixels, -0.6, 0.15);
  EXPECT_GT(r.likeness.ncc, 0.999);
}

TEST(Region, HoldsThePixelsWhoseCentresItHolds) {
  const Map a = map_of(40, 30, [](double x, double y) { return x + 100.0 * y; });
  const Map part = cut(a, {2.0, 4.0, 1.0, 1.5});
  EXPECT_EQ(part.width, 4U);
  EXPECT_EQ(part.height, 1U);
  EXPECT_EQ(part.luminance_cd_m2.front(), 204.0);
  const Evenness e = evenness(part);
  EXPECT_EQ(e.maximum, 207.0);
  EXPECT_NEAR(e.uniformity, 204.0 / 205.5, 1e-12);
  EXPECT_NE(failure_of([&] {
              cut(a, {30.0, 40.0, 0.0, 5.0});
            }).find("no pixel"),
            std::string::npos);
}

// One even source: 8 lg(0.25/Lb · L² ω).
TEST(Glare, OfAnEvenSourceIsTheFormulaOfCie117) {
  const Map even = map_of(40, 30, [](double, double) { return 5000.0; });
  const Glare glare{20.0, 3.0, 1.5};
  const double omega = 40 * 30 * 0.25 / 9e6;
  const double ugr = 8.0 * std::log10(0.25 / 20.0 * 5000.0 * 5000.0 * omega / 2.25);
  EXPECT_NEAR(glare_rating(even, glare).ugr_map, ugr, 1e-9);
  EXPECT_NEAR(glare_rating(even, glare).ugr_uniform, ugr, 1e-9);
  const Map spot = map_of(40, 30, hill);
  EXPECT_GT(glare_rating(spot, glare).ugr_map, glare_rating(spot, glare).ugr_uniform);
}

// Which estimator is the least noisy depends on the surface; both together are never far from it.
TEST(Estimators, AgreeAndTheCombinationIsNoNoisierThanTheBest) {
  const auto plastic =
      std::make_shared<Surface>("plastic", PlanesSurface(dense_mcpet(), 0, mcpet_total));
  const auto two = std::make_shared<Surface>("two", mcpet_diffuse_specular());
  for (const auto& surface : {matt(0.984), std::shared_ptr<const Surface>(plastic),
                              std::shared_ptr<const Surface>(two)}) {
    const PaperChamber chamber(surface, 0.5, {0.0, PaperChamber::height},
                               {0.0, PaperChamber::radius});
    const Tracer tracer(chamber.luminaire);
    Camera camera;
    camera.centre = Vec3(0, 4.0, PaperChamber::height + 5.0);
    camera.width = 10;
    camera.height = 4;
    camera.pixel_mm = 2.0;
    double mean[3], variance[3], error[3];
    for (int e = 0; e < 3; ++e) {
      MapRequest request;
      request.estimator = static_cast<Estimator>(e);
      // The first needs no shadow rays: nearly twice the paths for the same rays.
      request.rays_per_pixel = e == 0 ? 2000 : 1100;
      const Map map = luminance_map(tracer, camera, request);
      mean[e] = evenness(map).mean;
      variance[e] = 0.0;
      for (const double se : map.luminance_se) variance[e] += se * se;
      error[e] = std::sqrt(variance[e]) / static_cast<double>(map.luminance_se.size());
      variance[e] *= static_cast<double>(map.work.rays);
    }
    EXPECT_NEAR(mean[0], mean[2], 4.0 * std::hypot(error[0], error[2])) << surface->name();
    EXPECT_NEAR(mean[1], mean[2], 4.0 * std::hypot(error[1], error[2])) << surface->name();
    EXPECT_LT(variance[2], 1.1 * std::min(variance[0], variance[1])) << surface->name();
  }
}

TEST(ResultFiles, BringBackWhatTheyWereGiven) {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / "umov-result-files";
  std::filesystem::create_directories(folder);
  Result result;
  result.map = map_of(12, 7, hill);
  Luminaire l;
  l.add_emitter(disc(0, 0, 0, 5.0, 3.0), matt(0.0));
  result.distribution = intensity_distribution(Tracer(l), {.rays = 6400, .planes = 4, .angles = 7});
  result.keys = {{"seed", "1"}};
  write_sim_h5(folder / "sim.h5", result, {});
  const Result back = read_sim_h5(folder / "sim.h5");
  EXPECT_EQ(back.map->luminance_cd_m2, result.map->luminance_cd_m2);
  EXPECT_EQ(back.map->width, 12U);
  EXPECT_EQ(back.map->pixel_mm, 0.5);
  EXPECT_EQ(back.distribution->intensity_cd, result.distribution->intensity_cd);
  EXPECT_EQ(back.distribution->out_lm, result.distribution->out_lm);
  write_map_exr(folder / "map.exr", *result.map);
  std::size_t width = 0;
  std::size_t height = 0;
  const std::vector<double> y = formats::read_exr(folder / "map.exr", "Y", width, height);
  ASSERT_EQ(width, 12U);
  ASSERT_EQ(height, 7U);
  EXPECT_NEAR(y[0], result.map->at(0, 6), 1e-4);  // the top row comes first
  EXPECT_NE(failure_of([&] {
              formats::read_exr(folder / "map.exr", "Z", width, height);
            }).find("no such channel"),
            std::string::npos);
  EXPECT_NE(failure_of([&] {
              formats::read_exr(folder / "sim.h5", "Y", width, height);
            }).find("cannot read"),
            std::string::npos);
  EXPECT_TRUE(map_png(*result.map).starts_with("\x89PNG"));
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace umov::chamber
