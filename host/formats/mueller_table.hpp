// Measured Mueller-matrix BRDF at single directions, as full polarimeters deliver it.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "host/formats/brdf_table.hpp"

namespace umov::formats {

/// Directions and frames of this project (docs/physics.md section 1): forward phi = 0, theta_r
/// signed in plane, Q > 0 is s, U > 0 is s + p. `mueller[n]` is f row by row in 1/sr.
struct MuellerTable {
  std::vector<std::pair<std::string, std::string>> keys;
  std::vector<double> theta_i_deg, theta_r_deg, phi_r_deg, wavelength_nm;
  std::vector<std::array<double, 16>> mueller;
  /// One sigma, independent from point to point: of m00 relative to itself, and of the elements of
  /// the linear-polarisation block (m01 … m22) relative to m00.
  std::vector<double> m00_relative_u, element_relative_u;
  std::size_t size() const { return mueller.size(); }
};

/// Polariser and analyser axes in degrees from p towards +s; NaN (open_axis) = open.
struct PolarizationState {
  double polarizer_deg;
  double analyzer_deg;
};

/// BRDF seen by polariser and analyser: half of (1, -cos 2a, sin 2a, 0) on the detection side,
/// (1, -cos 2p, sin 2p, 0) on the incident side, (1, 0, 0, 0) where open. 1/sr.
double contract(const std::array<double, 16>& mueller, PolarizationState state);

/// Points for every state asked for, in the order point by point, state by state. More than four P,
/// S and open states are functions of one another (PU = PP + PS …): good to look values up in,
/// wrong to fit as if each were a measurement of its own (independent_channels() is for that).
BrdfTable to_brdf_table(const MuellerTable& table, const std::vector<PolarizationState>& states);

/// open/open, then P and S against P, S and open.
std::vector<PolarizationState> standard_states();

/// As a measurement with uncertainties that a fit may trust: the four states PP, PS, SP, SS and the
/// matrices themselves in BrdfTable::mueller. The four are ½ times a Hadamard matrix of m00, m01,
/// m10, m11, so independent channels of one uncertainty give each of these elements that
/// uncertainty: it is the larger of the scale's and the elements', m00 max(r, e).
BrdfTable independent_channels(const MuellerTable& table);

/// The matrices of a table that came through brdf.h5, its uncertainties taken to be those of
/// independent_channels(). Throws umov::Error for a table without 4 × 4 elements.
MuellerTable mueller_table(const BrdfTable& table);

}  // namespace umov::formats
