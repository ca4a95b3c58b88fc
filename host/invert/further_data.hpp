// Which further measurement would tell apart what these data confuse.
#pragma once

#include "host/formats/fit_file.hpp"
#include "host/invert/minimise.hpp"

namespace umov::invert {

/// Fills `remedies` of a result whose correlations and identifiability are set, and adds a sentence
/// for each confusion to `identifiability`. The linearised fit is repeated with hypothetical points
/// of the present noise: polarised channels or ±45° channels, rows out of the plane of incidence,
/// another incidence, as far as the data have none. Judged with the calibration held.
void describe_further_data(const Problem& problem, const Solution& solution,
                           formats::FitResult& fit);

}  // namespace umov::invert
