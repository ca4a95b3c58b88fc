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

/// Points for every state asked for, in the order point by point, state by state.
BrdfTable to_brdf_table(const MuellerTable& table, const std::vector<PolarizationState>& states);

/// open/open, then P and S against P, S and open.
std::vector<PolarizationState> standard_states();

}  // namespace umov::formats
