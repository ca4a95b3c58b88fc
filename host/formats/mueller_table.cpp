#include "host/formats/mueller_table.hpp"

#include <cmath>
#include <numbers>

#include "host/formats/scan_table.hpp"

namespace umov::formats {
namespace {

/// (I, Q, U) of a linear polariser or the row of an analyser, without the analyser's one half.
std::array<double, 3> axis_vector(double axis_deg) {
  if (is_open(axis_deg)) return {1, 0, 0};
  const double twice = 2 * axis_deg * std::numbers::pi / 180;
  return {1, -std::cos(twice), std::sin(twice)};
}

double analyzer_factor(double axis_deg) {
  return is_open(axis_deg) ? 1.0 : 0.5;
}

/// Independent uncertainty of a contraction: the scale m00 and the elements' own scatter.
double contraction_u(double value, double m00, PolarizationState state, double m00_relative_u,
                     double element_relative_u) {
  const auto out = axis_vector(state.analyzer_deg);
  const auto in = axis_vector(state.polarizer_deg);
  double weight = 0;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      if (i + j > 0) weight += out[i] * in[j] * out[i] * in[j];
  const double factor = analyzer_factor(state.analyzer_deg);
  return std::hypot(value * m00_relative_u, factor * m00 * element_relative_u * std::sqrt(weight));
}

}  // namespace

double contract(const std::array<double, 16>& mueller, PolarizationState state) {
  const auto out = axis_vector(state.analyzer_deg);
  const auto in = axis_vector(state.polarizer_deg);
  double sum = 0;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) sum += out[i] * mueller[4 * i + j] * in[j];
  return analyzer_factor(state.analyzer_deg) * sum;
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
