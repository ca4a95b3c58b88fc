// Sorting measured directions: into planes of incidence, incidence angles and polarisation states.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace umov::report {

/// Within this angle of the plane of incidence a direction counts as lying in it: detectors accept
/// about a degree, and tables of real instruments are off by tenths.
inline constexpr double in_plane_within_deg = 1.0;

/// φ in any turn; near θr = 0 every direction lies in the plane.
bool in_plane(double theta_r_deg, double phi_r_deg);
/// Signed θr: positive on the mirror side (φ near 0), negative on the side of the source.
double signed_theta_r(double theta_r_deg, double phi_r_deg);

/// Values that lie within `within` of their neighbour form one group, named by its mean (rounded to
/// 0.01). Ascending.
std::vector<double> clusters(std::vector<double> values, double within);
/// Index of the nearest entry of an ascending, non-empty list.
std::size_t nearest(const std::vector<double>& list, double value);

/// Axes of polariser and analyser, degrees, formats::open_axis = open.
struct State {
  double polarizer_deg = 0;
  double analyzer_deg = 0;
  std::string id() const;  ///< "P,S"
  bool operator==(const State& other) const;
};

/// Distinct states, those without analyser first (U, P, S incident), then PP, PS, SS, SP, then
/// others.
std::vector<State> distinct_states(const std::vector<double>& polarizer_deg,
                                   const std::vector<double>& analyzer_deg);

}  // namespace umov::report
