#include "hil/plant/polarization.hpp"

#include <cmath>

namespace umov::plant {

Stokes source_stokes(double degree, double axis_deg) {
  const double a = 2.0 * optics::radians(axis_deg);
  return Stokes(1.0, -degree * std::cos(a), degree * std::sin(a), 0.0);
}

Mueller polarizer_mueller(double axis_deg, double extinction) {
  const double angle = 2.0 * optics::radians(axis_deg);
  const double q = -std::cos(angle);
  const double u = std::sin(angle);
  const double mean = 0.5 * (1.0 + extinction);
  const double half_difference = 0.5 * (1.0 - extinction);
  const double cross = std::sqrt(extinction);
  Mueller m = optics::zero_mueller<double>();
  optics::set_element(m, 0, 0, mean);
  optics::set_element(m, 0, 1, half_difference * q);
  optics::set_element(m, 0, 2, half_difference * u);
  optics::set_element(m, 1, 0, half_difference * q);
  optics::set_element(m, 2, 0, half_difference * u);
  optics::set_element(m, 1, 1, mean * q * q + cross * u * u);
  optics::set_element(m, 1, 2, (mean - cross) * q * u);
  optics::set_element(m, 2, 1, (mean - cross) * q * u);
  optics::set_element(m, 2, 2, mean * u * u + cross * q * q);
  optics::set_element(m, 3, 3, cross);
  return m;
}

Mueller retarder_mueller(double axis_deg, double retardance_deg) {
  const double angle = 2.0 * optics::radians(axis_deg);
  const double q = -std::cos(angle);
  const double u = std::sin(angle);
  const double c = std::cos(optics::radians(retardance_deg));
  const double s = std::sin(optics::radians(retardance_deg));
  // On the sphere of (Q, U, V) it turns by the retardance about the axis (q, u, 0).
  Mueller m = optics::zero_mueller<double>();
  optics::set_element(m, 0, 0, 1.0);
  optics::set_element(m, 1, 1, q * q + c * u * u);
  optics::set_element(m, 1, 2, (1.0 - c) * q * u);
  optics::set_element(m, 1, 3, s * u);
  optics::set_element(m, 2, 1, (1.0 - c) * q * u);
  optics::set_element(m, 2, 2, u * u + c * q * q);
  optics::set_element(m, 2, 3, -s * q);
  optics::set_element(m, 3, 1, -s * u);
  optics::set_element(m, 3, 2, s * q);
  optics::set_element(m, 3, 3, c);
  return m;
}

Stokes photodiode_row(double bias) {
  return Stokes(1.0, bias, 0.0, 0.0);
}

Stokes row_times(const Stokes& row, const Mueller& m) {
  Stokes out(0.0);
  for (int column = 0; column < 4; ++column) {
    for (int i = 0; i < 4; ++i) out[column] += row[i] * optics::element(m, i, column);
  }
  return out;
}

}  // namespace umov::plant
