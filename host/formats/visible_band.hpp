// The band "Visible" of building and lighting programs: daylight D65 seen by the eye.
#pragma once

#include <span>
#include <vector>

namespace umov::formats {

/// Shares, adding up to 1, of spectral values at `wavelengths_um` (ascending) in their mean over
/// the visible band, weighted with the CIE illuminant D65 and the luminous efficiency V(λ) (CIE 15
/// at 10 nm and host/optics, from 400 to 700 nm). Between the wavelengths the values are taken as
/// linear, beyond them as constant; a wavelength that the band does not reach has share 0.
std::vector<double> visible_shares(std::span<const double> wavelengths_um);

}  // namespace umov::formats
