// Degree of linear polarisation from matching geometries (P4).
#pragma once

#include <cstddef>

#include "host/formats/brdf_table.hpp"

namespace umov::calibrate {

struct DolpCount {
  std::size_t measured = 0;  ///< divided by a measured BRDF without analyser
  std::size_t summed = 0;    ///< divided by PP + PS, as no such record matched
  std::size_t skipped = 0;   ///< no counterpart, or total below three times its uncertainty
};

/// Fills `table.dolp` from used points: (PP - PS)/PU with P incident. Repeats are averaged with
/// their weights. `dolp_u` holds noise and shared factors (which cancel for the most part).
DolpCount add_dolp(formats::BrdfTable& table);

}  // namespace umov::calibrate
