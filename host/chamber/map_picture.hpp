// A luminance map as a picture with a legend.
#pragma once

#include <string>

#include "host/chamber/camera.hpp"
#include "host/formats/image_file.hpp"

namespace umov::chamber {

/// Bytes of a PNG: grey from black (0) to white (`largest_cd_m2`; 0: the map's own maximum) with
/// axes in mm and a scale in cd/m². Every pixel is drawn as at least `least_width`/width squares.
std::string map_png(const Map& map, double largest_cd_m2 = 0.0, std::size_t least_width = 900);

}  // namespace umov::chamber
