// Asking for a face's material alone, against asking for all of the meeting.
#include <gtest/gtest.h>

#include <cmath>

#include "host/optics/angles.hpp"
#include "host/trace/geometry.hpp"
#include "host/trace/random_stream.hpp"

namespace umov::trace {
namespace {

TEST(NearestMaterial, IsThatOfTheNearestFaceOfEveryKind) {
  Scene scene({0.5});
  scene.periodic = false;
  std::array<MaterialId, 4> materials{};
  for (MaterialId& one : materials) one = scene.add(Lambertian{{0.5}});
  scene.spheres.push_back({optics::Vec3<double>(0, 0, 2), 1.0, materials[0]});
  scene.tubes.push_back({0, 0, 5.0, 0.0, 8.0, true, materials[1]});
  scene.plates.push_back({0, 0, 0.0, 5.0, true, materials[2]});
  Triangles mesh;
  mesh.vertices = {{1, 1, 4}, {3, 1, 4}, {1, 4, 5}};
  mesh.faces = {{0, 1, 2}};
  mesh.materials = {materials[3]};
  scene.meshes.push_back(mesh);
  const Geometry geometry(scene);
  std::array<int, 5> met{};
  for (std::uint64_t i = 0; i < 5000; ++i) {
    const auto u = uniforms(1, i, 0);
    const double z = 2.0 * u[0] - 1.0;
    const double phi = 2.0 * optics::pi * u[1];
    const double sine = std::sqrt(1.0 - z * z);
    const optics::Vec3<double> direction(sine * std::cos(phi), sine * std::sin(phi), z);
    const optics::Vec3<double> origin(4.0 * u[2] - 2.0, -2.0, 4.5 + u[3]);
    const double limit = i % 2 == 0 ? 1e9 : 3.0;
    const auto hit = geometry.nearest(origin, direction, limit);
    const auto material = geometry.nearest_material(origin, direction, limit);
    ASSERT_EQ(hit.has_value(), material.has_value());
    if (hit) {
      ASSERT_EQ(hit->material, *material);
    }
    ++met[hit ? static_cast<std::size_t>(hit->material) : 4];
  }
  for (const int count : met) EXPECT_GT(count, 10);
}

}  // namespace
}  // namespace umov::trace
