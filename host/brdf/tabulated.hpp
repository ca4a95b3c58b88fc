// The model `tabulated`: a table's values, with derivatives by the angles where they are wanted.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <type_traits>

#include "host/brdf/table.hpp"
#include "host/optics/dual.hpp"

namespace umov::brdf {

/// Half the distance, in radians, over which a table is differentiated: far below any sampling of
/// angles, far above rounding.
inline constexpr double table_difference_step = 1e-5;

/// sum += the table's matrix. It has no parameters, so that only dual-number angles bring
/// derivatives: central differences of the table, one-sided at normal incidence and at the horizon.
template <class T, class A>
[[gnu::noinline]] void add_tabulated(optics::Mueller<T>& sum, const Table& table,
                                     double wavelength_um, const Geometry<A>& geometry) {
  const Geometry<double> at{optics::value_of(geometry.theta_i), optics::value_of(geometry.theta_r),
                            optics::value_of(geometry.phi_r)};
  const optics::Mueller<double> value = table.at(wavelength_um, at);
  if constexpr (!optics::DualNumber<A>) {
    for (int column = 0; column < 4; ++column) {
      for (int row = 0; row < 4; ++row) sum[column][row] += value[column][row];
    }
  } else {
    constexpr double h = table_difference_step;
    const double horizon = 0.5 * optics::pi;
    std::array<optics::Mueller<double>, 3> slope;
    const auto difference = [&](std::size_t angle, double below, double above) {
      const auto moved = [&](double change) {
        Geometry<double> g = at;
        (angle == 0 ? g.theta_i : angle == 1 ? g.theta_r : g.phi_r) += change;
        return table.at(wavelength_um, g);
      };
      slope[angle] = (moved(above) - moved(-below)) * (1.0 / (above + below));
    };
    difference(0, at.theta_i < h ? 0.0 : h, at.theta_i + h < horizon ? h : 0.0);
    difference(1, at.theta_r - h > -horizon ? h : 0.0, at.theta_r + h < horizon ? h : 0.0);
    difference(2, h, h);
    for (int column = 0; column < 4; ++column) {
      for (int row = 0; row < 4; ++row) {
        sum[column][row] += optics::lift<T, 3>(
            value[column][row],
            {slope[0][column][row], slope[1][column][row], slope[2][column][row]},
            {geometry.theta_i, geometry.theta_r, geometry.phi_r});
      }
    }
  }
}

}  // namespace umov::brdf
