// Simulated hemispheres as pictures: a polar map, for eyes (PNG) and as numbers (OpenEXR).
//
// The centre of a map is the surface's normal, its rim grazing exit; the radius is θr/90°. φr = 0,
// the side to which a mirror reflects, is to the right, φr = 90° up. A pixel has the value of the
// cell that its middle lies in.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "host/trace/simulation.hpp"

namespace umov::surface {

/// Where light came from in a result.
struct Hemispheres {
  const std::vector<trace::Result>& results;
  const std::vector<double>& theta_i_deg;     ///< one a result
  const std::vector<double>& wavelengths_um;  ///< of all
};

/// 32-bit channels `20deg.550nm.m00` … `m33` in 1/sr for every angle of incidence, wavelength and
/// Mueller element, and `20deg.550nm.m00_se`, the standard error of m00; `A` is 1 inside of the
/// map, where all else is 0 outside. Five pixels a ring of cells and side. Throws umov::Error.
void write_hemisphere_exr(const std::filesystem::path& path, const Hemispheres& hemispheres);

/// Bytes of a PNG of m00 (row = column = 0) or of the share m_row,column/m00 at a wavelength, with
/// circles of θr, a mark in the mirror direction and a scale. m00 has a logarithmic scale where its
/// cells differ by more than a factor of 20.
std::string hemisphere_png(const trace::Result& result, double theta_i_deg, double wavelength_um,
                           std::size_t wavelength, int row, int column);

}  // namespace umov::surface
