// Tabular BSDF files of Zemax OpticStudio (.bsdf): docs/formats/zemax.md.
#pragma once

#include <string>
#include <string_view>

#include "host/formats/specular_table.hpp"
#include "host/formats/table_file.hpp"

namespace umov::formats {

/// Where a file without a "# wavelength:" comment is taken to stand, and the X, Y, Z of a
/// tristimulus file: the peaks of the CIE 1931 colour-matching functions, Z, Y, X.
inline constexpr double zemax_unnamed_um = 0.55;
inline constexpr double zemax_tristimulus_um[3] = {0.446, 0.555, 0.599};

bool looks_like_zemax(std::string_view bytes);
/// Reflection from isotropic surfaces (one sample rotation). Throws umov::Error with the line.
TablePtr read_zemax(std::string_view bytes, const std::string& name);
/// One wavelength, or the three of a tristimulus file read before. A SpecularTable keeps its own
/// angles; any other table is sampled on a grid that is fine near the mirror direction.
std::string write_zemax(const brdf::Table& table, const TableWriting& writing);

}  // namespace umov::formats
