// A BRDF sampled over half vector and difference angle, in cells, as the MERL data base does it.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "host/brdf/table.hpp"

namespace umov::formats {

/// Half vector h at polar angle θh from the normal; the beam towards the source stands at polar
/// angle θd and azimuth φd from h, φd counted from the plane of h and the normal.
struct HalfAngles {
  double theta_h, theta_d, phi_d;  ///< radians; φd in [-π, π]
};

HalfAngles half_angles(const brdf::Geometry<double>& geometry);
/// The reverse. Directions below the horizon come out with θi or θr above π/2.
brdf::Geometry<double> geometry_of(const HalfAngles& angles);

/// Numbers of cells. θh cells are bounded by (π/2)(k/n)², which makes them fine at the peak of a
/// gloss; θd cells are even over 0 … 90°, φd cells over 0 … 180° (reciprocity makes φd and φd +
/// 180° the same).
struct HalfAngleCells {
  std::size_t theta_h, theta_d, phi_d;
  std::size_t count() const { return theta_h * theta_d * phi_d; }
  /// Middle of a cell: of θh by the square root, of the others by the angle.
  HalfAngles middle(std::size_t h, std::size_t d, std::size_t p) const;
};

/// Values of three colour channels, red, green, blue, as a MERL file stores them: BRDF in 1/sr
/// divided by the channel's scale; negative where nothing is known.
///
/// A cell's value stands for its middle, between middles it interpolates linearly (θh by its square
/// root), without the cells in which nothing is known. Where all neighbours are unknown, the
/// nearest known one at smaller θd serves; where there is none the BRDF is 0.
class HalfAngleTable final : public brdf::Table {
 public:
  static constexpr std::array<double, 3> channel_scale = {1.0 / 1500.0, 1.15 / 1500.0,
                                                          1.66 / 1500.0};
  /// Where the channels stand, blue, green, red: rounded dominant wavelengths of the sRGB
  /// primaries. A MERL file names no wavelengths; its channels are those of a camera.
  static constexpr std::array<double, 3> channel_um = {0.464, 0.549, 0.611};

  /// `stored` runs channel (slowest), θh, θd, φd. Throws umov::Error for a wrong number of values
  /// or one that is not finite. `origin` names the source.
  HalfAngleTable(HalfAngleCells cells, std::vector<double> stored, std::string origin);

  optics::Mueller<double> at(double wavelength_um,
                             const brdf::Geometry<double>& geometry) const override;
  const std::vector<double>& wavelengths_um() const override { return wavelengths_um_; }
  bool polarised() const override { return false; }
  std::string description() const override;

  const HalfAngleCells& cells() const { return cells_; }
  std::span<const double> stored() const { return stored_; }
  const std::string& origin() const { return origin_; }

 private:
  HalfAngleCells cells_;
  std::vector<double> stored_;
  std::string origin_;
  std::vector<double> wavelengths_um_;
};

}  // namespace umov::formats
