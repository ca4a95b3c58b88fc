// The virtual hemisphere: cells of equal solid angle over all exit directions, and a fine strip
// along the plane of incidence.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "host/trace/scene.hpp"

namespace umov::trace {

/// A box of exit directions, radians. Of the strip: θr signed, φ = 0, and `phi_low`, `phi_high` are
/// the limits of the angle out of the plane.
struct Cell {
  double theta_low, theta_high;
  double phi_low, phi_high;
  double solid_angle;
  double projected;  ///< ∫ cos θr dΩ
};

/// Cells 0 … cells() - 1 lie in rings about the normal and have the same solid angle; those of a
/// ring are centred so that φ = 0 runs through the middle of the first. Cells from cells() on are
/// the strip, from θr = -90° to 90°; it overlaps the others.
class Hemisphere {
 public:
  /// `rings` of cells about 90°/rings wide (18: 5°, 827 cells); `strip_cells` over 180° (0: no
  /// strip), reaching `strip_half_width` (radians) to both sides of the plane. Throws umov::Error
  /// for rings outside 1 to 180, more than 3600 strip cells, or a half width outside 0 to 45°.
  Hemisphere(std::size_t rings, std::size_t strip_cells, double strip_half_width);

  std::size_t cells() const { return cells_; }
  std::size_t strip_cells() const { return strip_cells_; }
  std::size_t size() const { return cells_ + strip_cells_; }
  Cell cell(std::size_t index) const;

  /// The cell of a unit vector with z > 0.
  std::size_t find(const Vec3& direction) const;
  /// Its cell in the strip, if it is in the strip.
  std::optional<std::size_t> find_in_strip(const Vec3& direction) const;

 private:
  std::size_t ring_of(double z) const;

  std::size_t cells_ = 0;
  std::size_t strip_cells_;
  double strip_half_width_;
  double strip_sine_;
  std::vector<std::size_t> first_;  // cell of each ring, and cells_
  std::vector<double> boundary_;    // cos θ, from 1 down to 0
};

}  // namespace umov::trace
