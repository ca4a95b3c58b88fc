// umov simulate surface --mixture: how wrong is mixing materials by area?
#pragma once

#include <vector>

#include "host/cli/surface_run.hpp"

namespace umov::cli {

/// Prints the analysis (JSON where asked), and writes it to the output file as JSON.
void run_mixture(const SurfaceOptions& options, const std::vector<double>& coverage_factors,
                 const Common& common, const Ranks& ranks);

}  // namespace umov::cli
