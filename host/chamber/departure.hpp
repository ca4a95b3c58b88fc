// What may be otherwise in a real luminaire than its description says, and luminaires that can be
// built so: what a simulated measurement with a fault, and a diagnosis, change.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "host/chamber/camera.hpp"
#include "host/chamber/luminaire.hpp"

namespace umov::chamber {

/// Added to what the description says; nothing differs where all is zero. Lengths in mm.
struct Departure {
  double shift_x_mm = 0.0, shift_y_mm = 0.0;  ///< of all sources, with the holes they shine through
  double ring_mm = 0.0;                       ///< to the radius of each ring of sources
  double depth_mm = 0.0;                      ///< of sources below the holes of a chamber's base
  double edge_rho = 0.0;                      ///< to the reflectance of these holes' edges
  double view_deg = 0.0;                      ///< of the observer from +z
  std::vector<double> excess = {};            ///< of each source's flux over the stated one, less 1
};

/// A luminaire before the camera that looks at it.
struct View {
  Luminaire luminaire;
  Camera camera;
};

/// A luminaire that can be built with departures.
struct Described {
  /// Throws umov::Error where a departure leaves no room for what is described.
  std::function<View(const Departure&)> view;
  bool rings = false;  ///< of sources, wider than a point
  /// Of the sources that lie in holes of a chamber's base, the least; nothing where there are none.
  std::optional<double> least_depth_mm = {};
};

}  // namespace umov::chamber
