// How bright light of a wavelength is to the eye in daylight.
#pragma once

namespace umov::optics {

/// lm/W at the wavelength that is seen best.
inline constexpr double luminous_efficacy_lm_w = 683.0;

/// Where the table of V(λ) begins and ends, in µm.
inline constexpr double visible_from_um = 0.360;
inline constexpr double visible_to_um = 0.830;

/// V(λ) of the CIE 1924 photopic observer (CIE 18.2, every 5 nm from 380 to 780 nm, every 10 nm
/// beyond), linear in between, 0 outside 360 to 830 nm.
double luminous_efficiency(double wavelength_um);

}  // namespace umov::optics
