#include "host/trace/scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "host/errors/error.hpp"

namespace umov::trace {
namespace {

[[noreturn]] void refuse(std::string problem, std::string remedy) {
  throw Error(Place{"scene"}, std::move(problem), std::move(remedy));
}

void check_spectrum(const std::vector<double>& values, std::size_t count, double low, double high,
                    const std::string& what) {
  if (values.size() != count) {
    refuse(fmt::format("{} has {} values for {} wavelengths", what, values.size(), count),
           "give one value a wavelength");
  }
  for (const double v : values) {
    if (!(v >= low && v <= high)) {
      refuse(fmt::format("{} is {}", what, v),
             std::isfinite(high) ? fmt::format("it must be from {} to {}", low, high)
                                 : fmt::format("it must be at least {}", low));
    }
  }
}

constexpr double unlimited = std::numeric_limits<double>::max();
constexpr double least_index = 1e-3;

struct CheckMaterial {
  const Scene& scene;
  std::size_t count;
  std::string name;

  void operator()(const Lambertian& m) const {
    check_spectrum(m.albedo, count, 0.0, 1.0, name + ": albedo");
  }
  void operator()(const Conductor& m) const {
    check_spectrum(m.n, count, least_index, unlimited, name + ": n");
    check_spectrum(m.kappa, count, 0.0, unlimited, name + ": kappa");
  }
  void operator()(const Interface& m) const {
    if (m.inside == vacuum || m.inside >= scene.media.size()) {
      refuse(name + ": its medium is unknown, or vacuum", "add the medium first");
    }
  }
  void operator()(const Modelled& m) const {
    const auto check_one = [&](const brdf::Sampler& sampler) {
      if (sampler.spectrum().size() == count) return;
      refuse(fmt::format("{}: the model has {} wavelengths, the scene {}", name,
                         sampler.spectrum().size(), count),
             "make the sampler with the scene's wavelengths");
    };
    check_one(m.sampler);
    for (const auto& [medium, wet] : m.immersed) check_one(wet);
  }
};

}  // namespace

Scene::Scene(std::vector<double> wavelengths) : wavelengths_um(std::move(wavelengths)) {
  media.push_back({std::vector<double>(wavelengths_um.size(), 1.0),
                   std::vector<double>(wavelengths_um.size(), 0.0)});
}

MediumId Scene::add(Medium medium) {
  media.push_back(std::move(medium));
  return static_cast<MediumId>(media.size() - 1);
}

MaterialId Scene::add(Material material) {
  materials.push_back(std::move(material));
  return static_cast<MaterialId>(materials.size() - 1);
}

void Scene::add_plane(double z, MaterialId material) {
  const float x = static_cast<float>(size_x);
  const float y = static_cast<float>(size_y);
  const float height = static_cast<float>(z);
  // Wider than the domain, so that no face ends where a periodic path steps over.
  const float margin = 0.1F * std::max(x, y);
  meshes.push_back({{{-margin, -margin, height},
                     {x + margin, -margin, height},
                     {x + margin, y + margin, height},
                     {-margin, y + margin, height}},
                    {{0, 1, 2}, {0, 2, 3}},
                    {material, material}});
}

void Scene::add_height_field(std::size_t nx, std::size_t ny, const std::vector<double>& heights,
                             MaterialId material) {
  if (nx < 2 || ny < 2 || heights.size() != nx * ny) {
    refuse(fmt::format("{} heights for {} × {} points", heights.size(), nx, ny),
           "give nx·ny heights, at least 2 × 2");
  }
  // One row of cells more at each side than the domain has.
  const std::size_t columns = nx + 3;
  const std::size_t rows = ny + 3;
  Triangles mesh;
  mesh.vertices.reserve(columns * rows);
  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t column = 0; column < columns; ++column) {
      const double x = (static_cast<double>(column) - 1.0) * size_x / static_cast<double>(nx);
      const double y = (static_cast<double>(row) - 1.0) * size_y / static_cast<double>(ny);
      const double z = heights[((row + ny - 1) % ny) * nx + (column + nx - 1) % nx];
      mesh.vertices.push_back(
          {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)});
    }
  }
  for (std::size_t row = 0; row + 1 < rows; ++row) {
    for (std::size_t column = 0; column + 1 < columns; ++column) {
      const auto a = static_cast<std::uint32_t>(row * columns + column);
      const auto above = a + static_cast<std::uint32_t>(columns);
      // Diagonals in turn: all alike would tie slopes in x to slopes in y.
      if ((row + column) % 2 == 0) {
        mesh.faces.push_back({a, a + 1, above + 1});
        mesh.faces.push_back({a, above + 1, above});
      } else {
        mesh.faces.push_back({a, a + 1, above});
        mesh.faces.push_back({a + 1, above + 1, above});
      }
    }
  }
  mesh.materials.assign(mesh.faces.size(), material);
  meshes.push_back(std::move(mesh));
}

std::uint64_t Scene::faces() const {
  std::uint64_t count = spheres.size() + tubes.size() + plates.size();
  for (const Triangles& mesh : meshes) count += mesh.faces.size();
  return count;
}

void Scene::check() const {
  const std::size_t count = wavelengths_um.size();
  if (count == 0) refuse("it has no wavelength", "give at least one");
  check_spectrum(wavelengths_um, count, 1e-3, 1e3, "a wavelength in micrometres");
  if (!(size_x > 0.0) || !(size_y > 0.0)) {
    refuse(fmt::format("its domain is {} × {}", size_x, size_y), "both sizes must be above 0");
  }
  if (media.size() > most_media) {
    refuse(fmt::format("it has {} media", media.size()), fmt::format("use at most {}", most_media));
  }
  for (std::size_t i = 0; i < media.size(); ++i) {
    check_spectrum(media[i].n, count, least_index, unlimited, fmt::format("medium {}: n", i));
    check_spectrum(media[i].kappa, count, 0.0, unlimited, fmt::format("medium {}: kappa", i));
  }
  for (std::size_t i = 0; i < materials.size(); ++i) {
    std::visit(CheckMaterial{*this, count, fmt::format("material {}", i)}, materials[i]);
  }
  for (std::size_t i = 0; i < spheres.size(); ++i) {
    const Sphere& s = spheres[i];
    if (!(s.radius > 0.0)) {
      refuse(fmt::format("sphere {} has radius {}", i, s.radius), "radii must be above 0");
    }
    if (s.material >= materials.size()) {
      refuse(fmt::format("sphere {} has material {} of {}", i, s.material, materials.size()),
             "add the material first");
    }
    if (periodic && 4.0 * s.radius > std::min(size_x, size_y)) {
      refuse(fmt::format("sphere {} is wider than half the periodic domain", i),
             "make the domain larger");
    }
    if (periodic &&
        !(s.centre.x >= 0.0 && s.centre.x <= size_x && s.centre.y >= 0.0 && s.centre.y <= size_y)) {
      refuse(fmt::format("the centre of sphere {} is outside the domain", i),
             "wrap it into the domain");
    }
  }
  if (periodic && !(tubes.empty() && plates.empty())) {
    refuse("it repeats and has round faces", "make it a scene that does not repeat");
  }
  for (const Tube& t : tubes) {
    if (!(t.radius > 0.0 && t.top > t.bottom)) {
      refuse(
          fmt::format("a tube has radius {} and reaches from {} to {}", t.radius, t.bottom, t.top),
          "give it a radius and a height above 0");
    }
    if (t.material >= materials.size()) refuse("a tube has no material", "add the material first");
  }
  for (const Plate& p : plates) {
    if (!(p.radius > 0.0)) {
      refuse(fmt::format("a plate has radius {}", p.radius), "radii must be above 0");
    }
    for (const Plate::Hole& hole : p.holes) {
      if (!(hole.radius > 0.0) || std::hypot(hole.x - p.x, hole.y - p.y) + hole.radius > p.radius) {
        refuse(fmt::format("a hole of radius {} at ({}, {}) reaches over its plate", hole.radius,
                           hole.x, hole.y),
               "make it smaller or move it inwards");
      }
    }
    if (p.material >= materials.size()) refuse("a plate has no material", "add the material first");
  }
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    const Triangles& mesh = meshes[i];
    if (mesh.materials.size() != mesh.faces.size()) {
      refuse(fmt::format("mesh {} has {} materials for {} faces", i, mesh.materials.size(),
                         mesh.faces.size()),
             "give one material a face");
    }
    for (const MaterialId m : mesh.materials) {
      if (m >= materials.size()) {
        refuse(fmt::format("mesh {} has material {} of {}", i, m, materials.size()),
               "add the material first");
      }
    }
    for (const auto& face : mesh.faces) {
      for (const std::uint32_t vertex : face) {
        if (vertex >= mesh.vertices.size()) {
          refuse(fmt::format("mesh {} has a face with vertex {} of {}", i, vertex,
                             mesh.vertices.size()),
                 "number vertices from 0");
        }
      }
    }
  }
}

}  // namespace umov::trace
