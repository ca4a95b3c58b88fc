// From what true polarisers and analysers see to what ideal ones would see.
//
// The points of one geometry and wavelength are linear in the nine elements of the linear Mueller
// block F: point = A(ψ)ᵀ F S(ψ), A and S the true vectors (polarization.hpp). F is estimated from
// all of them, and every point moves by (A₀ S₀ᵀ - A Sᵀ)·F to the ideal vectors A₀, S₀. Elements
// that the states do not determine are known only to lie within ± m00; in the plane of incidence
// the U row and column of an isotropic sample are zero.
#pragma once

#include <string>
#include <vector>

#include "host/calibrate/calibration.hpp"
#include "host/formats/brdf_table.hpp"

namespace umov::calibrate {

/// True where points of this wavelength refer to the true states of a polarisation calibration.
bool has_true_states(const Calibration& calibration, std::size_t wavelength);

/// Turns points and factors to ideal states, and adds the polarisation calibration's own factors:
/// "polarizer axis 532 nm", "analyzer extinction 532 nm" …, and "undetermined U elements 532 nm"
/// where they matter. Where δ is a parameter of the gain's fit, its share goes into the factors
/// that carry the fit's statistics ("detector bias 532 nm" among them). `wavelength` holds each
/// point's number in the calibration. Returns sentences for the summary. Points of other
/// wavelengths stay.
std::vector<std::string> to_ideal_states(formats::BrdfTable& table,
                                         const std::vector<std::size_t>& wavelength,
                                         const Calibration& calibration);

}  // namespace umov::calibrate
