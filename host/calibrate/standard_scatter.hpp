// How much the records of a standard scatter beyond what their noise law says.
#pragma once

#include <vector>

#include "host/calibrate/standard_fit.hpp"

namespace umov::calibrate {

/// Relative scatter of the records about the fit, one sigma, what the model of the standard misses
/// included; 0 where the noise explains it. By the median, which outliers do not move. `rows` are
/// those of the fit; fewer than twenty say nothing.
double scatter_about_fit(const std::vector<StandardRow>& rows, const StandardFit& fit);

/// The same from one angle to the next: what is smooth in the angle is taken out, state by state,
/// as a standard that polarises a little is no noise. Repeats of one geometry follow each other
/// within seconds and miss what changes over minutes; this does not.
double scatter_between_angles(const std::vector<StandardRow>& rows, const StandardFit& fit);

}  // namespace umov::calibrate
