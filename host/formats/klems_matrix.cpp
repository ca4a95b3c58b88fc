#include "host/formats/klems_matrix.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace umov::formats {
namespace {

std::size_t turned(std::size_t patch, std::size_t by, std::size_t ring_patches) {
  return (patch + by) % ring_patches;
}

std::size_t mirrored(std::size_t patch, std::size_t ring_patches) {
  return (ring_patches - patch) % ring_patches;
}

struct Power {
  double total = 0, difference = 0;
};

/// Compares every pair of patches of two rings with the mean over its turned and mirrored copies.
void compare_rings(const KlemsMatrix& matrix, std::size_t ring_i, std::size_t ring_o,
                   Power& power) {
  const auto ni = static_cast<std::size_t>(matrix.incident.rings()[ring_i].patches);
  const auto no = static_cast<std::size_t>(matrix.exit.rings()[ring_o].patches);
  const std::size_t turns = std::gcd(ni, no);
  const std::size_t first_i = matrix.incident.first_of(ring_i);
  const std::size_t first_o = matrix.exit.first_of(ring_o);
  const double weight = matrix.incident.patch(first_i).projected_solid_angle() *
                        matrix.exit.patch(first_o).projected_solid_angle();
  const auto value = [&](std::size_t o, std::size_t i) {
    return matrix.at(first_o + o, first_i + i);
  };
  for (std::size_t i = 0; i < ni; ++i)
    for (std::size_t o = 0; o < no; ++o) {
      double mean = 0;
      for (std::size_t k = 0; k < turns; ++k) {
        const std::size_t ti = turned(i, k * (ni / turns), ni);
        const std::size_t to = turned(o, k * (no / turns), no);
        mean += value(to, ti) + value(mirrored(to, no), mirrored(ti, ni));
      }
      mean /= 2.0 * static_cast<double>(turns);
      power.total += weight * value(o, i);
      power.difference += weight * std::abs(value(o, i) - mean);
    }
}

}  // namespace

std::vector<double> directional_hemispherical(const KlemsMatrix& matrix) {
  std::vector<double> dhr(matrix.incident.size(), 0.0);
  for (std::size_t o = 0; o < matrix.exit.size(); ++o) {
    const double solid_angle = matrix.exit.patch(o).projected_solid_angle();
    for (std::size_t i = 0; i < dhr.size(); ++i) dhr[i] += solid_angle * matrix.at(o, i);
  }
  return dhr;
}

double anisotropy(const KlemsMatrix& matrix) {
  Power power;
  for (std::size_t i = 0; i < matrix.incident.rings().size(); ++i)
    for (std::size_t o = 0; o < matrix.exit.rings().size(); ++o) compare_rings(matrix, i, o, power);
  return power.total > 0 ? power.difference / power.total : 0;
}

}  // namespace umov::formats
