// How a fit does on rows that it has not seen.
#pragma once

#include <optional>

#include "host/invert/search.hpp"

namespace umov::invert {

/// Fits again without every fifth row and returns mean(z²) − 1 over those rows; nullopt where the
/// rest would be too few points for the model.
std::optional<double> held_out_gap(const Layout& layout, const Observations& data,
                                   const Priors& priors, const Found& found,
                                   const Options& options);

}  // namespace umov::invert
