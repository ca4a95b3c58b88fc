#include "host/chamber/mixing_chamber.hpp"

#include <cmath>

#include "host/optics/angles.hpp"

namespace umov::chamber {

using optics::radians;

Luminaire MixingChamber::luminaire() const {
  Luminaire l;
  const double radius = 0.5 * diameter_mm;
  const double hole = 0.5 * hole_diameter_mm;
  const trace::MaterialId side = l.add(wall);
  const trace::MaterialId base = l.add(wall);
  l.scene.tubes.push_back({0.0, 0.0, radius, 0.0, height_mm, true, side});
  trace::Plate plate{0.0, 0.0, 0.0, radius, true, base};
  const auto black = std::make_shared<const Surface>("black", Lambertian{0.0});
  const auto edge = std::make_shared<const Surface>("edge", Lambertian{edge_rho});
  for (std::size_t i = 0; i < flux_lm.size(); ++i) {
    const double a = radians(azimuth_deg + 90.0 * static_cast<double>(i));
    const double x = shift_x_mm + ring_radius_mm * std::cos(a);
    const double y = shift_y_mm + ring_radius_mm * std::sin(a);
    plate.holes.push_back({x, y, hole});
    Emitter e{};
    e.name = "source " + std::to_string(i + 1);
    e.flux_lm = flux_lm[i];
    e.centre = Vec3(x, y, -depth_mm);
    e.normal = Vec3(0.0, 0.0, 1.0);
    e.half_u = Vec3(hole, 0.0, 0.0);
    e.half_v = Vec3(0.0, hole, 0.0);
    e.disc = true;
    l.add_emitter(e, black);
    if (depth_mm > 0.0) {
      l.scene.tubes.push_back({x, y, hole, -depth_mm, 0.0, true, l.add(edge)});
    }
  }
  l.scene.plates.push_back(plate);
  if (spot_width_deg > 0.0) {
    // A strip of flat faces a hair's breadth before the wall.
    const trace::MaterialId dirt =
        l.add(std::make_shared<const Surface>("spot", Lambertian{spot_rho}));
    constexpr int pieces = 16;
    trace::Triangles mesh;
    const double half_step = 0.5 * radians(spot_width_deg) / pieces;
    const double inner = 0.999 * radius * std::cos(half_step);
    for (int i = 0; i <= pieces; ++i) {
      const double a = radians(spot_azimuth_deg - 0.5 * spot_width_deg) + 2.0 * half_step * i;
      for (const double z : {0.01 * height_mm, 0.99 * height_mm}) {
        mesh.vertices.push_back({static_cast<float>(inner * std::cos(a)),
                                 static_cast<float>(inner * std::sin(a)), static_cast<float>(z)});
      }
    }
    for (std::uint32_t i = 0; i < pieces; ++i) {
      const std::uint32_t v = 2 * i;
      mesh.faces.push_back({v, v + 1, v + 2});  // fronts look at the axis
      mesh.faces.push_back({v + 1, v + 3, v + 2});
    }
    mesh.materials.assign(mesh.faces.size(), dirt);
    l.scene.meshes.push_back(std::move(mesh));
  }
  l.opening_z = height_mm;
  l.opening_diameter_mm = diameter_mm;
  return l;
}

Camera MixingChamber::camera(std::size_t coarser) const {
  Camera c;
  c.centre = Vec3(0.0, 0.0, height_mm);
  c.view_deg = view_deg;
  c.width = 300 / coarser;
  c.height = 125 / coarser;
  c.pixel_mm = 0.2 * static_cast<double>(coarser);
  return c;
}

Described MixingChamber::described() const {
  const auto view = [chamber = *this](const Departure& d) {
    MixingChamber c = chamber;
    c.shift_x_mm += d.shift_x_mm;
    c.shift_y_mm += d.shift_y_mm;
    c.ring_radius_mm += d.ring_mm;
    c.depth_mm += d.depth_mm;
    c.edge_rho += d.edge_rho;
    c.view_deg += d.view_deg;
    for (std::size_t i = 0; i < d.excess.size(); ++i) c.flux_lm.at(i) *= 1.0 + d.excess[i];
    return View{c.luminaire(), c.camera()};
  };
  return {view, ring_radius_mm > 0.0, depth_mm};
}

}  // namespace umov::chamber
