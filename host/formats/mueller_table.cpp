#include "host/formats/mueller_table.hpp"

#include <cmath>
#include <numbers>

#include "host/formats/scan_table.hpp"
#include "host/optics/mueller.hpp"

namespace umov::formats {
namespace {

optics::Stokes<double> source_of(PolarizationState state) {
  return is_open(state.polarizer_deg) ? optics::unpolarized<double>()
                                      : optics::polarizer_stokes<double>(state.polarizer_deg);
}

optics::Stokes<double> analyzer_of(PolarizationState state) {
  return is_open(state.analyzer_deg) ? optics::unpolarized<double>()
                                     : optics::analyzer_stokes<double>(state.analyzer_deg);
}

/// Independent uncertainty of a contraction: the scale m00 and the elements' own scatter.
double contraction_u(double value, double m00, PolarizationState state, double m00_relative_u,
                     double element_relative_u) {
  const auto out = analyzer_of(state), in = source_of(state);
  double weight = 0;
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j)
      if (i + j > 0) weight += out[i] * in[j] * out[i] * in[j];
  return std::hypot(value * m00_relative_u, m00 * element_relative_u * std::sqrt(weight));
}

}  // namespace

double contract(const std::array<double, 16>& mueller, PolarizationState state) {
  optics::Mueller<double> matrix;
  for (int i = 0; i < 16; ++i)
    optics::set_element(matrix, i / 4, i % 4, mueller[static_cast<std::size_t>(i)]);
  return optics::contract<double>(analyzer_of(state), matrix, source_of(state));
}

std::vector<PolarizationState> standard_states() {
  constexpr double p = 0, s = 90;
  return {{open_axis, open_axis}, {p, p}, {p, s}, {p, open_axis}, {s, s}, {s, p}, {s, open_axis}};
}

BrdfTable to_brdf_table(const MuellerTable& table, const std::vector<PolarizationState>& states) {
  BrdfTable brdf;
  brdf.keys = table.keys;
  for (std::size_t n = 0; n < table.size(); ++n) {
    const auto& mueller = table.mueller[n];
    for (const PolarizationState state : states) {
      auto& p = brdf.points;
      p.theta_i_deg.push_back(table.theta_i_deg[n]);
      p.theta_r_deg.push_back(table.theta_r_deg[n]);
      p.phi_r_deg.push_back(table.phi_r_deg[n]);
      p.wavelength_nm.push_back(table.wavelength_nm[n]);
      p.polarizer_deg.push_back(state.polarizer_deg);
      p.analyzer_deg.push_back(state.analyzer_deg);
      const double value = contract(mueller, state);
      p.brdf_per_sr.push_back(value);
      p.brdf_u.push_back(contraction_u(value, mueller[0], state, table.m00_relative_u[n],
                                       table.element_relative_u[n]));
      p.used.push_back(1);
    }
    // (P4); the scale drops out of the ratio, what is left is the scatter of m10 and m11.
    const double all = contract(mueller, {0, open_axis});
    if (!(all > 0)) continue;
    auto& d = brdf.dolp;
    d.theta_i_deg.push_back(table.theta_i_deg[n]);
    d.theta_r_deg.push_back(table.theta_r_deg[n]);
    d.phi_r_deg.push_back(table.phi_r_deg[n]);
    d.wavelength_nm.push_back(table.wavelength_nm[n]);
    d.dolp.push_back((contract(mueller, {0, 0}) - contract(mueller, {0, 90})) / all);
    d.dolp_u.push_back(std::numbers::sqrt2 * mueller[0] * table.element_relative_u[n] / all);
  }
  return brdf;
}

}  // namespace umov::formats
