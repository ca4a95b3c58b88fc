#include "host/formats/mueller_table.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <fmt/format.h>

#include "host/errors/error.hpp"
#include "host/formats/scan_table.hpp"
#include "host/optics/mueller.hpp"
#include "host/optics/realisability.hpp"

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

namespace {

BrdfTable::Mueller matrices(const MuellerTable& table) {
  BrdfTable::Mueller m;
  m.side = 4;
  m.theta_i_deg = table.theta_i_deg;
  m.theta_r_deg = table.theta_r_deg;
  m.phi_r_deg = table.phi_r_deg;
  m.wavelength_nm = table.wavelength_nm;
  for (std::size_t n = 0; n < table.size(); ++n) {
    const auto& f = table.mueller[n];
    const double scale = table.m00_relative_u[n];
    const double scatter = f[0] * table.element_relative_u[n];
    double variance = 0;
    const auto found = optics::realisability(f);
    for (std::size_t k = 0; k < 16; ++k) {
      m.mueller.push_back(f[k]);
      m.mueller_u.push_back(k == 0 ? scale * f[0] : std::hypot(scale * f[k], scatter));
      if (k > 0) variance += found.slope[k] * found.slope[k] * scatter * scatter;
    }
    // The eigenvalue goes with the scale.
    variance += found.least_eigenvalue * found.least_eigenvalue * scale * scale;
    m.realisable_z.push_back(variance > 0 ? found.least_eigenvalue / std::sqrt(variance)
                                          : std::numeric_limits<double>::quiet_NaN());
  }
  m.condition.assign(table.size(), 1.0);
  m.chi2.assign(table.size(), 0.0);
  m.dof.assign(table.size(), 0.0);
  return m;
}

}  // namespace

BrdfTable independent_channels(const MuellerTable& table) {
  constexpr double p = 0, s = 90;
  const std::vector<PolarizationState> states = {{p, p}, {p, s}, {s, p}, {s, s}};
  BrdfTable brdf = to_brdf_table(table, states);
  for (std::size_t i = 0; i < brdf.points.size(); ++i) {
    const std::size_t n = i / states.size();
    brdf.points.brdf_u[i] =
        table.mueller[n][0] * std::max(table.m00_relative_u[n], table.element_relative_u[n]);
  }
  brdf.mueller = matrices(table);
  return brdf;
}

MuellerTable mueller_table(const BrdfTable& brdf) {
  if (!brdf.mueller || brdf.mueller->side != 4)
    throw Error("the table has no 4 x 4 Mueller elements",
                "import one, such as the NIST PTFE table");
  const BrdfTable::Mueller& m = *brdf.mueller;
  MuellerTable table;
  table.keys = brdf.keys;
  table.theta_i_deg = m.theta_i_deg;
  table.theta_r_deg = m.theta_r_deg;
  table.phi_r_deg = m.phi_r_deg;
  table.wavelength_nm = m.wavelength_nm;
  for (std::size_t n = 0; n < m.size(); ++n) {
    std::array<double, 16> f{};
    for (std::size_t k = 0; k < 16; ++k) f[k] = m.mueller[16 * n + k];
    if (!(f[0] > 0))
      throw Error(fmt::format("m00 of matrix {} is not positive", n), "check the file");
    table.mueller.push_back(f);
    const double scale = m.mueller_u[16 * n] / f[0];
    table.m00_relative_u.push_back(scale);
    // The scale's share in m11 taken out again.
    const double u11 = m.mueller_u[16 * n + 5] / f[0], of_scale = scale * f[5] / f[0];
    table.element_relative_u.push_back(std::sqrt(std::max(0.0, u11 * u11 - of_scale * of_scale)));
  }
  return table;
}

}  // namespace umov::formats
