// A scene as it is described: faces over a rectangular domain, their materials, the wavelengths.
//
// Lengths have any unit, but one: that of wavelength_um if a medium absorbs. The domain is
// 0 <= x <= size_x, 0 <= y <= size_y. Light comes from above (+z).
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string_view>
#include <vector>

#include "host/optics/mueller.hpp"
#include "host/trace/material.hpp"
#include "host/trace/round.hpp"

namespace umov::trace {

using Vec3 = optics::Vec3<double>;

/// Light outside meets its front. With `base_z` it is a cap: only what lies above is there (a drop
/// on a plane at base_z, contact angle β: radius R, centre at base_z - R cos β).
struct Sphere {
  Vec3 centre;
  double radius;
  MaterialId material;
  double base_z = -std::numeric_limits<double>::infinity();
};

/// Vertices are taken in single precision; the faces are exactly those of the rounded vertices. The
/// front of a face is where its vertices run counter-clockwise.
struct Triangles {
  std::vector<std::array<float, 3>> vertices;
  std::vector<std::array<std::uint32_t, 3>> faces;
  std::vector<MaterialId> materials;  ///< one a face
};

struct Scene {
  std::vector<double> wavelengths_um;
  double size_x = 1.0;
  double size_y = 1.0;
  /// The domain repeats without end in x and y. What reaches over an edge reappears at the other.
  bool periodic = true;
  std::vector<Medium> media;  ///< 0 is vacuum
  std::vector<Material> materials;
  std::vector<Sphere> spheres;
  std::vector<Triangles> meshes;
  std::vector<Tube> tubes;    ///< only in a scene that is not periodic
  std::vector<Plate> plates;  ///< likewise

  /// An empty scene with vacuum in it.
  explicit Scene(std::vector<double> wavelengths);

  MediumId add(Medium medium);
  MaterialId add(Material material);
  /// A horizontal face at `z` over the domain (and a little more); its front is above.
  void add_plane(double z, MaterialId material);
  /// nx × ny heights of a surface that repeats with the domain; heights[iy·nx + ix] stands at
  /// (ix·size_x/nx, iy·size_y/ny). Two triangles a cell; the front is above.
  void add_height_field(std::size_t nx, std::size_t ny, const std::vector<double>& heights,
                        MaterialId material);

  /// Spheres, triangles and round faces.
  std::uint64_t faces() const;

  /// Throws umov::Error that says which value is wrong: spectra that do not fit the wavelengths,
  /// indices <= 0, albedos outside 0 to 1, radii <= 0, spheres wider than half a periodic domain,
  /// round faces in one, unknown materials, an empty domain.
  void check() const;
};

}  // namespace umov::trace
