// How far a material is from the simplest one: one Gaussian lobe of facets over a diffuse part.
#pragma once

#include "hil/blind/change.hpp"

namespace umov::blind {

/// Whitened misfit of the best material of one Gaussian lobe (P8 with Smith's masking) and ρ_d1 +
/// ρ_d2/(cos θi cos θr) (P9), one gain a wavelength, to the scan without effects: what a richer
/// reflectance model could gain. 0 for a material that is one. Every third row is used and the
/// result scaled up to all.
double beyond_one_gaussian_lobe(const World& world);

}  // namespace umov::blind
