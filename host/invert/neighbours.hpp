// Prediction without a model: the nearest measured directions.
#pragma once

#include <vector>

#include "host/formats/brdf_table.hpp"

namespace umov::invert {

/// For every marked point of `wanted` the value that the four nearest points of `known` suggest:
/// same wavelength and polarisation state, distance in half-vector angle and difference angle, mean
/// of the logarithms with weights of 1/distance². A point never predicts itself. NaN where nothing
/// is known, 0 for points that are not wanted.
std::vector<double> from_neighbours(const formats::BrdfTable& table, const std::vector<bool>& known,
                                    const std::vector<bool>& wanted);

}  // namespace umov::invert
