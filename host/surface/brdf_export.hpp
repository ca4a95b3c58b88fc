// A simulated hemisphere as a BRDF table, which every format of the toolkit and every command
// takes.
#pragma once

#include <vector>

#include "host/formats/brdf_table.hpp"
#include "host/trace/simulation.hpp"

namespace umov::surface {

/// Which directions: the cells of the hemisphere, the strip in the plane of incidence, or both.
/// Both hold the same light: a fit should take one of them.
enum class Directions { cells, strip, both };

/// All 16 elements with their standard errors at the middle of each cell that light was seen in,
/// m00 as points without polariser and analyser, and the DHR. Directions of the strip have φr = 0
/// and a signed θr. `scene` is the one that was simulated, `theta_i_deg` its angle.
formats::BrdfTable brdf_table(const trace::Result& result, const trace::Scene& scene,
                              double theta_i_deg, Directions directions);

}  // namespace umov::surface
