// What a model says a cell of the hemisphere should hold.
#pragma once

#include <cmath>
#include <vector>

#include "host/brdf/evaluate.hpp"
#include "host/trace/hemisphere.hpp"

namespace umov::trace {

/// Mean of a model's BRDF over a cell, weighted by cos θ, from `points`² places; not for cells of
/// the strip.
inline optics::Mueller<double> over_cell(const brdf::Model& model,
                                         const std::vector<double>& values, double wavelength_um,
                                         double theta_i, const Cell& cell, int points) {
  optics::Mueller<double> sum(0.0);
  const double low = std::pow(std::sin(cell.theta_low), 2);
  const double high = std::pow(std::sin(cell.theta_high), 2);
  for (int i = 0; i < points; ++i) {
    const double theta = std::asin(std::sqrt(low + (i + 0.5) / points * (high - low)));
    for (int j = 0; j < points; ++j) {
      const double phi = cell.phi_low + (j + 0.5) / points * (cell.phi_high - cell.phi_low);
      sum += brdf::evaluate<double>(model, values, wavelength_um,
                                    brdf::Geometry<double>{theta_i, theta, phi});
    }
  }
  return sum / (1.0 * points * points);
}

}  // namespace umov::trace
