// Starting values from the data: lobe widths by measuring them, the coefficients in which the model
// is linear by solving for them, the rest by trying many.
#pragma once

#include <cstdint>
#include <vector>

#include "host/invert/residuals.hpp"

namespace umov::invert {

/// For each parameter of the model: is the BRDF jointly linear in it and the others so marked?
/// Found by comparing gradients at two points, so it holds for any model.
std::vector<bool> linear_parameters(const Layout& layout, const Observations& data);

/// Coordinates with the linear parameters at their bounded least-squares optimum, given the others.
std::vector<double> with_linear_solved(const Layout& layout, const Observations& data,
                                       const std::vector<bool>& linear, std::vector<double> x);

/// 1-D rms slope (tangent) that the width of the mirror lobes tells; 0.3 where no lobe stands out.
double lobe_slope(const Observations& data);

/// Starting points in the order of merit (best first): `count` out of several times as many, on
/// thinned data. The point made of initial values is always tried, and parameters with a user's
/// start keep it.
std::vector<std::vector<double>> starting_points(const Layout& layout, const Observations& thinned,
                                                 double slope_rms, int count, std::uint64_t seed,
                                                 int threads);

}  // namespace umov::invert
