// What a scene refuses, and how faces are found where geometry touches, grazes and repeats.
#include <gtest/gtest.h>

#include <cmath>

#include "host/errors/error.hpp"
#include "tests/unit/trace/scenes.hpp"

namespace umov::trace {
namespace {

using optics::radians;
using test::shine;

Scene one_sphere(double radius) {
  Scene scene({0.5});
  scene.spheres.push_back({Vec3(0.5, 0.5, 0.5), radius, scene.add(Lambertian{{0.5}})});
  return scene;
}

TEST(Scene, RefusesWhatItCannotBe) {
  EXPECT_THROW(Scene({}).check(), Error);
  EXPECT_THROW(one_sphere(0.0).check(), Error);
  EXPECT_THROW(one_sphere(0.3).check(), Error) << "wider than half a period";
  EXPECT_NO_THROW(one_sphere(0.25).check());
  Scene scene({0.5});
  scene.add(Lambertian{{1.1}});
  EXPECT_THROW(scene.check(), Error);
  Scene spectrum({0.5, 0.6});
  spectrum.add(Conductor{{1.0}, {2.0, 3.0}});
  EXPECT_THROW(spectrum.check(), Error);
  Scene unknown({0.5});
  unknown.add_plane(0.0, 3);
  EXPECT_THROW(unknown.check(), Error);
  Scene medium({0.5});
  medium.add(Interface{1});
  EXPECT_THROW(medium.check(), Error);
  EXPECT_THROW(medium.add_height_field(3, 3, {0.0}, 0), Error);
}

TEST(Geometry, ARayLeavesTheFaceItStartsOnAndMeetsASphereAtItsFarSide) {
  Scene scene({0.5});
  const MaterialId white = scene.add(Lambertian{{1.0}});
  scene.add_plane(0.0, white);
  scene.spheres.push_back({Vec3(0.5, 0.5, 0.25), 0.25, white});
  const Geometry geometry(scene);
  EXPECT_FALSE(geometry.nearest(Vec3(0.1, 0.1, 0.0), Vec3(0.0, 0.0, 1.0), 10.0));
  EXPECT_FALSE(geometry.nearest(Vec3(0.1, 0.1, 0.0), Vec3(0.0, 0.0, -1.0), 10.0));
  const auto down = geometry.nearest(Vec3(0.5, 0.5, 0.5), Vec3(0.0, 0.0, -1.0), 10.0);
  ASSERT_TRUE(down);
  EXPECT_NEAR(down->distance, 0.5, 1e-15) << "through the sphere, to where it touches the ground";
  EXPECT_FALSE(geometry.nearest(Vec3(0.5, 0.5, 0.5), Vec3(0.0, 0.0, 1.0), 10.0));
  // In the gap of 2e-9 between sphere and ground, far below single precision.
  const double x = 0.5 + std::sqrt(2.0 * 0.25 * 2e-9);
  const auto gap = geometry.nearest(Vec3(x, 0.5, 0.0), Vec3(0.0, 0.0, 1.0), 10.0);
  ASSERT_TRUE(gap);
  EXPECT_NEAR(gap->distance, 2e-9, 1e-13);
}

TEST(Geometry, ACapEndsAtItsBase) {
  Scene scene({0.5});
  const MaterialId skin = scene.add(Lambertian{{1.0}});
  scene.spheres.push_back({Vec3(0.5, 0.5, -0.1), 0.2, skin, 0.0});
  const Geometry geometry(scene);
  EXPECT_NEAR(geometry.bottom(), 0.0, 1e-15);
  const auto top = geometry.nearest(Vec3(0.5, 0.5, 1.0), Vec3(0.0, 0.0, -1.0), 10.0);
  ASSERT_TRUE(top);
  EXPECT_NEAR(top->distance, 0.9, 1e-15);
  EXPECT_FALSE(geometry.nearest(Vec3(0.5, 0.5, -1.0), Vec3(1.0, 0.0, 0.0), 10.0));
  const auto inner = geometry.nearest(Vec3(0.5, 0.5, -1.0), Vec3(0.0, 0.0, 1.0), 10.0);
  ASSERT_TRUE(inner);
  EXPECT_NEAR(inner->position.z, 0.1, 1e-15) << "the lower half is not there";
}

TEST(Period, ShiftingTheSceneUnderTheLightChangesNothing) {
  // The same spheres, whole inside the domain and cut by its edges: mean number of meetings and
  // reflectance must agree, also for light that crosses many periods.
  const auto reflectance = [](double shift, double degrees) {
    Scene scene({0.5});
    scene.add_plane(0.0, scene.add(Lambertian{{0.2}}));
    const MaterialId soil = scene.add(Lambertian{{0.8}});
    for (const double x : {0.25, 0.75}) {
      scene.spheres.push_back(
          {Vec3(std::fmod(x + shift, 1.0), std::fmod(0.3 + shift, 1.0), 0.15), 0.15, soil});
    }
    test::Mean mean;
    double sum = 0.0;
    shine(
        scene, radians(degrees), 20000, 11, [&](const Exit& exit) { sum += exit.weight[0][0]; },
        [&] { mean.add(sum), sum = 0.0; });
    return mean;
  };
  for (const double degrees : {30.0, 80.0}) {
    const auto whole = reflectance(0.0, degrees);
    const auto cut = reflectance(0.7, degrees);
    EXPECT_NEAR(whole.value(), cut.value(), 4.0 * std::hypot(whole.error(), cut.error()))
        << degrees;
    EXPECT_LT(whole.error(), 0.005);
  }
}

TEST(HeightField, LosesNoMoreThanAFewPathsInAMillion) {
  Scene scene({0.5});
  std::vector<double> heights;
  for (int i = 0; i < 64 * 64; ++i) {
    heights.push_back(0.01 * uniforms(12, static_cast<std::uint64_t>(i), 0)[0]);
  }
  scene.add_height_field(64, 64, heights, scene.add(Lambertian{{1.0}}));
  for (const double degrees : {0.0, 89.0}) {
    double above = 0.0;
    const Ledger ledger = shine(scene, radians(degrees), 200000, 13,
                                [&](const Exit& exit) { above += exit.weight[0][0]; });
    // A few light paths in a million meet a face from behind, at grazing incidence.
    EXPECT_EQ(ledger.below[0], 0.0) << degrees;
    EXPECT_LE(ledger.lost[0], 1e-5 * ledger.launched[0]) << degrees;
    EXPECT_NEAR(above + ledger.lost[0], ledger.launched[0], 1e-6) << degrees;
  }
}

}  // namespace
}  // namespace umov::trace
