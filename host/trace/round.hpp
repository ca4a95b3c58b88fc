// Faces with an exact circle in them, with a vertical axis: walls of cylinders, and horizontal
// plates with holes. Everything is decided in double precision; Embree sees their boxes only.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "host/optics/mueller.hpp"
#include "host/trace/material.hpp"

namespace umov::trace {

/// The wall of a cylinder about the vertical through (x, y), from `bottom` to `top`.
struct Tube {
  double x, y, radius;
  double bottom, top;
  bool inward;  ///< the front looks at the axis
  MaterialId material;
};

/// A horizontal disc with holes; none of them reaches over another or over the edge.
struct Plate {
  struct Hole {
    double x, y, radius;
  };
  double x, y, z, radius;
  bool upward;  ///< the front looks up
  MaterialId material;
  std::vector<Hole> holes = {};
};

/// Box of a face: lower corner, then upper corner.
using Box = std::array<optics::Vec3<double>, 2>;
Box box_of(const Tube& tube);
Box box_of(const Plate& plate);

/// Distance of the nearest meeting above 0 and up to `limit`, where there is one. A start that is
/// within `on_face` of the face lies on it and is not met again there.
std::optional<double> meeting(const Tube& tube, const optics::Vec3<double>& origin,
                              const optics::Vec3<double>& direction, double limit, double on_face);
std::optional<double> meeting(const Plate& plate, const optics::Vec3<double>& origin,
                              const optics::Vec3<double>& direction, double limit, double on_face);

/// The unit normal at a point, towards the front.
optics::Vec3<double> normal_at(const Tube& tube, const optics::Vec3<double>& position);
optics::Vec3<double> normal_at(const Plate& plate, const optics::Vec3<double>& position);

/// A point of the face near `position`, inside its edges by 1e-9 of its size: at a crease the next
/// ray starts on one face only.
optics::Vec3<double> settled(const Tube& tube, const optics::Vec3<double>& position);
optics::Vec3<double> settled(const Plate& plate, const optics::Vec3<double>& position);

}  // namespace umov::trace
