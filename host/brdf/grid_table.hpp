// A table over a full grid of directions: incidence × exit angle × azimuth × wavelength.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "host/brdf/table.hpp"

namespace umov::brdf {

/// Where values stand. Each axis rises strictly; one entry is enough.
struct GridAxes {
  std::vector<double> theta_i_deg;    ///< [0, 90)
  std::vector<double> theta_r_deg;    ///< [0, 90]
  std::vector<double> phi_r_deg;      ///< within [0, 180], or within [-180, 180]
  std::vector<double> wavelength_um;  ///< > 0
};

/// Linear interpolation in all four coordinates, beyond the outermost entries the nearest one.
///
/// With azimuths of [0, 180] the surface is taken as mirror symmetric about the plane of incidence
/// (elements of U and V change sign with φ); an axis with a negative azimuth is the full circle
/// and closes over ±180°. Unpolarised grids hold m00, polarised ones 16 elements, row by row, in
/// the {s, p} bases of docs/physics.md at each entry's own direction.
class GridTable : public Table {
 public:
  /// `values` are in 1/sr and run wavelength (slowest), θi, θr, φ, element; `elements` is 1 or 16.
  /// `origin` names the source in errors and in description(). Throws umov::Error, with the place
  /// of the entry, for an axis that does not rise or leaves its range, a wrong number of values, a
  /// value that is not a finite number, and a negative m00.
  GridTable(GridAxes axes, std::vector<double> values, int elements, std::string origin);

  optics::Mueller<double> at(double wavelength_um, const Geometry<double>& geometry) const override;
  const std::vector<double>& wavelengths_um() const override { return axes_.wavelength_um; }
  bool polarised() const override { return elements_ == 16; }
  std::string description() const override;
  ExitBreaks exit_breaks() const override;

  const GridAxes& axes() const { return axes_; }
  std::span<const double> values() const { return values_; }
  int elements() const { return elements_; }
  const std::string& origin() const { return origin_; }

 private:
  GridAxes axes_;
  std::vector<double> values_;
  int elements_;
  std::string origin_;
  bool full_circle_;
};

}  // namespace umov::brdf
