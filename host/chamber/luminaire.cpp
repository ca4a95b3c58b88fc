#include "host/chamber/luminaire.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "host/optics/frames.hpp"

namespace umov::chamber {

Luminaire::Luminaire() : scene({0.555}) {
  scene.periodic = false;
}

trace::MaterialId Luminaire::add(std::shared_ptr<const Surface> surface, bool turned) {
  surfaces.push_back(std::move(surface));
  emitter_of.push_back(-1);
  inside_out.push_back(turned);
  return scene.add(trace::Lambertian{{0.0}});
}

void Luminaire::add_emitter(Emitter emitter, std::shared_ptr<const Surface> surface) {
  emitter.material = add(std::move(surface));
  emitter_of.back() = static_cast<int>(emitters.size());
  if (emitter.disc) {
    scene.plates.push_back({emitter.centre.x, emitter.centre.y, emitter.centre.z,
                            std::sqrt(optics::dot(emitter.half_u, emitter.half_u)),
                            emitter.normal.z > 0.0, emitter.material});
  } else {
    constexpr double single_precision = 1.2e-7;
    double farthest = 0.0;
    trace::Triangles mesh;
    for (const auto& [u, v] : {std::pair{-1.0, -1.0}, {1.0, -1.0}, {1.0, 1.0}, {-1.0, 1.0}}) {
      const Vec3 p = emitter.centre + u * emitter.half_u + v * emitter.half_v;
      mesh.vertices.push_back(
          {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)});
      farthest = std::max({farthest, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
    }
    emitter.clearance_mm = 2.0 * single_precision * farthest;
    mesh.faces = {{0, 1, 2}, {0, 2, 3}};
    mesh.materials = {emitter.material, emitter.material};
    scene.meshes.push_back(std::move(mesh));
  }
  emitters.push_back(std::move(emitter));
}

void Luminaire::add_box(const Vec3& from, const Vec3& to, bool inward, trace::MaterialId material,
                        const std::vector<bool>& left_out) {
  trace::Triangles mesh;
  for (unsigned corner = 0; corner < 8; ++corner) {
    mesh.vertices.push_back({static_cast<float>((corner & 1U) != 0 ? to.x : from.x),
                             static_cast<float>((corner & 2U) != 0 ? to.y : from.y),
                             static_cast<float>((corner & 4U) != 0 ? to.z : from.z)});
  }
  // -x, +x, -y, +y, -z, +z; counter-clockwise from outside.
  constexpr std::array<std::array<std::uint32_t, 4>, 6> sides{
      {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}};
  for (std::size_t i = 0; i < sides.size(); ++i) {
    if (i < left_out.size() && left_out[i]) continue;
    auto [a, b, c, d] = sides[i];
    if (inward) std::swap(b, d);
    mesh.faces.push_back({a, b, c});
    mesh.faces.push_back({a, c, d});
  }
  mesh.materials.assign(mesh.faces.size(), material);
  scene.meshes.push_back(std::move(mesh));
}

double Luminaire::flux_lm() const {
  double sum = 0.0;
  for (const Emitter& emitter : emitters) sum += emitter.flux_lm;
  return sum;
}

}  // namespace umov::chamber
