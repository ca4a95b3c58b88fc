// The hemispherical integral of a table.
#pragma once

#include "host/brdf/adaptive_quadrature.hpp"
#include "host/brdf/table.hpp"

namespace umov::brdf {

/// ∫ m00 cos θr dω and ∫ m01 cos θr dω over the reflected hemisphere at `theta_i` in radians, [0,
/// π/2). Tables that name their exit_breaks() are integrated cell by cell, to 1e-9 of the value.
/// Any other is summed over directions that crowd about the mirror direction, on grids that double
/// until a doubling changes the sum by less than `wanted` (relative above 1) or `most_divisions`
/// each way are used, 4 million directions with 2048; `error` is the last change either way.
Integral integrate_table(const Table& table, double wavelength_um, double theta_i,
                         double wanted = 2e-5, int most_divisions = 2048);

}  // namespace umov::brdf
