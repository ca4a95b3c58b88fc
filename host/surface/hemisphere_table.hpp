// Simulated hemispheres as one table of a BRDF, for models, chambers and the emulated instrument.
#pragma once

#include <string>
#include <vector>

#include "host/brdf/grid_table.hpp"
#include "host/trace/simulation.hpp"

namespace umov::surface {

/// One simulation an angle of incidence, all with the same cells, angles ascending. The grid has
/// the middles of the rings, azimuths from 0 to 180° in steps of a ring's width and the wavelengths
/// of the scene; each entry is the mean of its cell and of that mirrored at the plane of incidence,
/// about which the surface is taken as symmetric. The table's lobes are as wide as its cells at
/// least. Throws umov::Error for angles that do not rise or are not as many as results.
brdf::GridTable hemisphere_table(const std::vector<trace::Result>& results,
                                 const std::vector<double>& theta_i_deg,
                                 const std::vector<double>& wavelengths_um,
                                 const std::string& origin);

}  // namespace umov::surface
