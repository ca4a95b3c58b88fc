// Points of an ASTM text, from the file's angles and quantities to a BRDF in this project's.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "host/formats/brdf_table.hpp"

namespace umov::formats::astm {

/// One value of a point, before angles are understood.
struct RawPoint {
  double theta_i, phi_i, theta_s, phi_s;  ///< in the file's unit
  double wavelength_nm, polarizer_deg, analyzer_deg, value;
  std::optional<double> uncertainty;
  double specular_azimuth_deg;  ///< phi_s - phi_i of the mirror direction
  bool times_cosine;
  int used;
  std::size_t line;
};

/// Adds a point with its angles in degrees (`degrees` is 1 or 180/pi) and the mirror direction at
/// azimuth 0. `relative_u` is the file's uncertainty as a share of the value. Throws umov::Error
/// with the point's line of `file` for angles out of range.
void add_point(BrdfTable::Points& out, const RawPoint& point, double degrees,
               std::optional<double> relative_u, const std::string& file);

/// Gives points whose file states no uncertainty one: a share of the value, and the noise that
/// shows in the values below zero at the same wavelength. Where none is negative a zero is as
/// uncertain as the smallest value known.
void assume_uncertainties(BrdfTable::Points& points);

}  // namespace umov::formats::astm
