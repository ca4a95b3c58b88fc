// Slopes of the facets that a beam sees on a surface with Gaussian slopes.
#pragma once

namespace umov::brdf {

/// x with ∫_{-∞}^x (1 - tilt·t) e^(-t²) dt = u · (the integral up to 1/tilt): the slope along the
/// plane of incidence, in units of √2 rms, of a facet that light at θi sees, for tilt = √2 rms
/// tan θi >= 0. tilt = 0 gives a plain Gaussian, the slope across. u in [0, 1); to 1e-8.
double visible_slope(double u, double tilt);

}  // namespace umov::brdf
