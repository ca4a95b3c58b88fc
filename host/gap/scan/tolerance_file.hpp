// Declared tolerances of a bench, as TOML: a table for each effect, an entry for each parameter.
//   [detector_zero]
//   zero_deg = 0.02                      # one standard deviation
//   [backlash]
//   gap_deg = { half_width = 0.05 }      # anywhere within ± 0.05
#pragma once

#include <string>
#include <vector>

#include "host/gap/scan/knowledge.hpp"

namespace umov::gap::scan {

/// A number is one standard deviation, and sizes up to two of them are within the tolerance. A
/// half-width is a limit: values within it are equally likely (u = half-width / √3, GUM 4.3.7).
/// Names of effects and parameters are not looked at here (apply_tolerances does). Throws
/// umov::Error with file and line for what is no such file.
std::vector<Tolerance> read_tolerances(const std::string& file);

}  // namespace umov::gap::scan
