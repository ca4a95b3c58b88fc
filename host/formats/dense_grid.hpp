// Sampling any table on a plain grid of directions.
#pragma once

#include <functional>
#include <vector>

#include "host/brdf/grid_table.hpp"

namespace umov::formats {

/// θi every 2.5 degrees to 87.5, θr every degree to 89, φ from 0 to 180 in steps that grow from 1
/// to 5 degrees; all 16 elements where the table is polarised. Unpolarised tables are averaged over
/// both sides of the plane of incidence.
brdf::GridTable dense_grid(const brdf::Table& table, std::vector<double> wavelengths_um,
                           const std::function<void(double done, double total)>& progress = {});

}  // namespace umov::formats
