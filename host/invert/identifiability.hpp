// Sentences about what the data can and cannot tell apart.
#pragma once

#include <string>
#include <vector>

#include "host/formats/fit_file.hpp"
#include "host/invert/posterior.hpp"

namespace umov::invert {

/// Fills correlations, identifiability and the estimates' `identifiable` of a result whose
/// parameters and derived quantities are set. Judged with the calibration held: a gain error common
/// to all coefficients is not a confusion between them.
void describe_identifiability(const Layout& layout, const Observations& data,
                              const Posterior& posterior, formats::FitResult& fit);

}  // namespace umov::invert
