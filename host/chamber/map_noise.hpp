// The noise of a luminance map that came without an error estimate, from the map itself.
#pragma once

#include <vector>

#include "host/chamber/camera.hpp"

namespace umov::chamber {

/// One standard deviation of every pixel in cd/m², as a function of luminance alone. Neighbours are
/// weighed 1 −2 1, −2 4 −2, 1 −2 1, which leaves nothing of a plane or of any sum of a function of
/// x and one of y, and six times the deviation of independent noise (Immerkær, Comput. Vis. Image
/// Underst. 64, 300, 1996); the median size of what is left, over classes of equal luminance, is
/// blind to edges. Noise that neighbours share (a resampled or smoothed image, the fixed pattern of
/// a sensor) is not seen. At least 1e-4 of the luminance. Throws umov::Error for fewer than 64
/// pixels that shine, as do their neighbours.
std::vector<double> estimated_noise(const Map& map);

}  // namespace umov::chamber
