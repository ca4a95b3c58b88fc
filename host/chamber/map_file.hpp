// Luminance maps that somebody measured: sim.h5, OpenEXR or CSV.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "host/chamber/camera.hpp"

namespace umov::chamber {

/// A map as a camera's window has it, with what had to be assumed of it.
struct MeasuredMap {
  Map map;  ///< every pixel with a standard error
  std::vector<std::string> notes;
};

/// By content. OpenEXR: channel Y in cd/m², and `se` where there is one. CSV: columns x_mm, y_mm of
/// the pixels' centres from the lower left, luminance_cd_m2 and, where known, luminance_se; rows in
/// any order, every pixel once. Without standard errors they are estimated (map_noise.hpp).
/// Throws umov::Error, with line or pixel, for a file of another kind, another number or size of
/// pixels than the camera's, values below zero or not finite, and a map that is dark all over.
MeasuredMap read_measured_map(const std::filesystem::path& path, const Camera& camera);

/// A map as such a CSV, with its standard errors: the shortest text of each number.
std::string map_csv_text(const Map& map);

}  // namespace umov::chamber
