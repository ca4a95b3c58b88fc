// Luminous faces: a horizontal disc or a flat rectangle with the same exitance everywhere, that
// sends its light after the cosine or after a photometric file.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "host/chamber/intensity_table.hpp"
#include "host/chamber/surface.hpp"
#include "host/trace/material.hpp"

namespace umov::chamber {

/// Lengths in mm.
struct Emitter {
  std::string name;
  double flux_lm;
  trace::MaterialId material;  ///< of its faces
  Vec3 centre, normal;
  /// Of a disc: a radius along C0. Of a rectangle: half of its edges. At right angles to each other
  /// and to the normal; C0 of a photometric file is along the first.
  Vec3 half_u, half_v;
  bool disc;
  std::shared_ptr<const IntensityTable> table = nullptr;  ///< nothing: Lambertian
  /// How far from here its faces may lie, whose corners are single precision.
  double clearance_mm = 0.0;
  /// W/nm of each lumen, by band of the luminaire; Bands::luminous() of it is 1.
  std::vector<double> spectrum = {};

  double area_mm2() const;
  /// A point for u1, u2 in [0, 1), uniform by area.
  Vec3 point(double u1, double u2) const;
  /// cd/m² towards a unit vector; 0 behind. `lm_per_m2` is flux over area.
  double luminance(const Vec3& towards, double lm_per_m2) const;
  /// A direction for a launch, with lumens over those of a launch after the emitter's mean.
  struct Launch {
    Vec3 direction;
    double weight;
  };
  Launch launch(double u1, double u2, double u3) const;
};

}  // namespace umov::chamber
