// Luminaires that several tests look at.
#pragma once

#include <cmath>
#include <memory>

#include "host/chamber/tracer.hpp"
#include "host/optics/angles.hpp"

namespace umov::chamber {

inline std::shared_ptr<const Surface> matt(double rho) {
  return std::make_shared<Surface>("matt", Lambertian{rho});
}

inline Emitter disc(double x, double y, double z, double radius, double flux_lm, bool up = true) {
  Emitter e{};
  e.name = "disc";
  e.flux_lm = flux_lm;
  e.centre = Vec3(x, y, z);
  e.normal = Vec3(0.0, 0.0, up ? 1.0 : -1.0);
  e.half_u = Vec3(radius, 0.0, 0.0);
  e.half_v = Vec3(0.0, up ? radius : -radius, 0.0);
  e.disc = true;
  return e;
}

/// [M]'s cylinder, 43 mm by 21.4 mm, with four sources `depth` below 5 mm holes on a ring of 6.6
/// mm. The wall is one material a zone, from below; then the base from the axis.
struct PaperChamber {
  static constexpr double radius = 21.5, height = 21.4, ring = 6.6, hole = 2.5, flux_lm = 0.96;
  Luminaire luminaire;
  std::vector<trace::MaterialId> wall, base;

  PaperChamber(const std::shared_ptr<const Surface>& surface, double depth,
               const std::vector<double>& wall_mm, const std::vector<double>& base_mm) {
    auto& scene = luminaire.scene;
    for (std::size_t i = 0; i + 1 < wall_mm.size(); ++i) {
      wall.push_back(luminaire.add(surface));
      scene.tubes.push_back({0, 0, radius, wall_mm[i], wall_mm[i + 1], true, wall.back()});
    }
    std::vector<trace::Plate::Hole> holes;
    for (int k = 0; k < 4; ++k) {
      const double a = optics::radians(90.0 * k);
      holes.push_back({ring * std::cos(a), ring * std::sin(a), hole});
      luminaire.add_emitter(disc(holes.back().x, holes.back().y, -depth, hole, flux_lm), matt(0.0));
      if (depth > 0.0) {
        scene.tubes.push_back(
            {holes.back().x, holes.back().y, hole, -depth, 0.0, true, luminaire.add(matt(0.0))});
      }
    }
    for (std::size_t i = 0; i + 1 < base_mm.size(); ++i) {
      base.push_back(luminaire.add(surface));
      trace::Plate plate{0, 0, 0, base_mm[i + 1], true, base.back()};
      if (base_mm[i] > 0.0) plate.holes.push_back({0, 0, base_mm[i]});
      // The ring of holes lies in one zone.
      if (base_mm[i] < ring && ring < base_mm[i + 1]) {
        plate.holes.insert(plate.holes.end(), holes.begin(), holes.end());
      }
      scene.plates.push_back(plate);
    }
    luminaire.opening_z = height;
    luminaire.opening_diameter_mm = 2.0 * radius;
  }
};

}  // namespace umov::chamber
