// Heights of a Gaussian rough surface that repeats.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace umov::surface {

/// side × side heights over a square of `size`; Gaussian in height, autocorrelation
/// exp(-r²/correlation²) (white noise convolved with a Gaussian), scaled so that the rms slope of
/// the triangles of trace::Scene::add_height_field() is `slope_rms` along one direction, in the
/// mean of x and y. `seed` decides all.
///
/// Throws umov::Error for a slope outside 0 to 3, fewer than 4 cells a correlation length (facets
/// would not follow the surface), or a domain below 8 correlation lengths (it would repeat itself).
std::vector<double> gaussian_heights(std::size_t side, double size, double correlation,
                                     double slope_rms, std::uint64_t seed);

}  // namespace umov::surface
