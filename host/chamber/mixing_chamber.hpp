// [M]'s mixing chamber with everything in it that a real one may have otherwise.
#pragma once

#include <array>
#include <memory>

#include "host/chamber/camera.hpp"
#include "host/chamber/departure.hpp"
#include "host/chamber/luminaire.hpp"

namespace umov::chamber {

/// Published: diameter, height, holes, flux, view. Not published: where the ring of holes lies and
/// how deep below the base the sources do. From 55° no hole is in view, so that a ring on the
/// diagonals has at most 9.3 mm; here 8 mm. The sheet is 1 mm thick and the sources lie behind it:
/// 1 mm.
struct MixingChamber {
  double diameter_mm = 43.0, height_mm = 21.4;
  double hole_diameter_mm = 5.0;
  double ring_radius_mm = 8.0, azimuth_deg = 45.0;
  double depth_mm = 1.0;
  double shift_x_mm = 0.0, shift_y_mm = 0.0;  ///< of all sources and holes
  std::array<double, 4> flux_lm{0.96, 0.96, 0.96, 0.96};
  double edge_rho = 0.0;
  double view_deg = 55.0;
  /// A spot of other reflectance on the wall, from its foot to its rim: where a real one is soiled.
  double spot_azimuth_deg = 90.0, spot_width_deg = 0.0, spot_rho = 0.5;
  std::shared_ptr<const Surface> wall;

  Luminaire luminaire() const;
  /// [M]'s window of 125 × 300 pixels of 0.2 mm; `coarser` times fewer and larger pixels.
  Camera camera(std::size_t coarser = 1) const;
  Described described() const;
};

}  // namespace umov::chamber
