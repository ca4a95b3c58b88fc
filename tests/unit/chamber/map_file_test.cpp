// Measured luminance maps: what is read, joined and estimated of them.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "host/chamber/figures.hpp"
#include "host/chamber/map_file.hpp"
#include "host/chamber/map_noise.hpp"
#include "host/chamber/result_file.hpp"
#include "tests/unit/failure.hpp"
#include "tests/unit/formats/scratch_folder.hpp"

namespace umov::chamber {
namespace {

/// A dome of light with an edge across it, and noise in proportion to it.
Map dome(std::size_t width, std::size_t height, double noise, unsigned seed) {
  std::mt19937_64 generator(seed);
  std::normal_distribution<double> normal;
  Map map;
  map.width = width;
  map.height = height;
  map.pixel_mm = 0.5;
  for (std::size_t y = 0; y < height; ++y) {
    for (std::size_t x = 0; x < width; ++x) {
      const double u = static_cast<double>(x) / static_cast<double>(width) - 0.5;
      const double v = static_cast<double>(y) / static_cast<double>(height) - 0.5;
      const double smooth = 300.0 * std::exp(-6.0 * (u * u + v * v)) + (u > 0.2 ? 60.0 : 0.0);
      map.luminance_cd_m2.push_back(smooth * (1.0 + noise * normal(generator)));
    }
  }
  map.luminance_se.assign(width * height, 0.0);
  return map;
}

Camera camera_of(const Map& map) {
  Camera camera;
  camera.width = map.width;
  camera.height = map.height;
  camera.pixel_mm = map.pixel_mm;
  return camera;
}

TEST(MapNoise, IsFoundToATenthWhereTheMapItselfChanges) {
  const Map map = dome(120, 80, 0.01, 3);
  const std::vector<double> sigma = estimated_noise(map);
  double dim = 0.0, bright = 0.0, dims = 0.0, brights = 0.0;
  for (std::size_t i = 0; i < sigma.size(); ++i) {
    const double share = sigma[i] / map.luminance_cd_m2[i];
    (map.luminance_cd_m2[i] < 100.0 ? dim : bright) += share;
    (map.luminance_cd_m2[i] < 100.0 ? dims : brights) += 1.0;
  }
  EXPECT_NEAR(bright / brights, 0.01, 0.001);
  EXPECT_NEAR(dim / dims, 0.01, 0.0015);
  Map quiet = dome(120, 80, 0.0, 3);
  const std::vector<double> least = estimated_noise(quiet);
  for (std::size_t i = 0; i < least.size(); ++i)
    EXPECT_GE(least[i], 0.99e-4 * quiet.luminance_cd_m2[i]);
  Map few = dome(9, 9, 0.0, 3);
  EXPECT_NE(failure_of([&] { estimated_noise(few); }).find("49 pixels shine"), std::string::npos);
}

TEST(MapFile, PixelsAreJoinedToTheirMeansAndTheirErrorsToTheErrorsOfMeans) {
  Map map = dome(7, 4, 0.0, 1);
  for (std::size_t i = 0; i < map.luminance_se.size(); ++i)
    map.luminance_se[i] = static_cast<double>(i);
  const Map half = joined(map, 2);
  EXPECT_EQ(half.width, 3U);
  EXPECT_EQ(half.height, 2U);
  EXPECT_EQ(half.pixel_mm, 1.0);
  const double mean = (map.at(2, 2) + map.at(3, 2) + map.at(2, 3) + map.at(3, 3)) / 4.0;
  EXPECT_NEAR(half.at(1, 1), mean, 1e-12 * mean);
  // Pixels 16, 17, 23 and 24.
  EXPECT_NEAR(half.luminance_se[4], std::sqrt(16. * 16 + 17 * 17 + 23 * 23 + 24 * 24) / 4, 1e-12);
  EXPECT_NE(failure_of([&] { joined(map, 5); }).find("cannot be joined"), std::string::npos);
}

TEST(MapFile, AnOpenExrFileComesBackTheRightWayUp) {
  const formats::testing::ScratchFolder folder;
  Map map = dome(12, 9, 0.02, 2);
  for (double& se : map.luminance_se) se = 1.5;
  map.luminance_se[0] = 2.5;
  const auto path = folder / "map.exr";
  write_map_exr(path, map);
  const MeasuredMap read = read_measured_map(path, camera_of(map));
  for (std::size_t i = 0; i < map.luminance_cd_m2.size(); ++i)
    EXPECT_NEAR(read.map.luminance_cd_m2[i], map.luminance_cd_m2[i], 1e-5 * 300.0);
  EXPECT_EQ(read.map.luminance_se[0], 2.5);
  EXPECT_TRUE(read.notes.empty());

  Camera other = camera_of(map);
  other.pixel_mm = 0.4;
  EXPECT_NE(failure_of([&] { read_measured_map(path, other); }).find("pixel_mm: is 0.5"),
            std::string::npos);
  map.luminance_cd_m2[14] = std::nan("");
  write_map_exr(path, map);
  EXPECT_NE(failure_of([&] { read_measured_map(path, camera_of(map)); }).find("pixel (2, 1)"),
            std::string::npos);
}

}  // namespace
}  // namespace umov::chamber
