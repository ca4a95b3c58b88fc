#include "host/formats/klems_table.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <utility>

#include "host/errors/error.hpp"
#include "host/optics/angles.hpp"

namespace umov::formats {

KlemsTable::KlemsTable(KlemsMatrix matrix, std::string band, double wavelength_um,
                       std::string description)
    : matrix_(std::move(matrix)),
      band_(std::move(band)),
      wavelengths_um_{wavelength_um},
      description_(std::move(description)) {
  if (matrix_.values.size() != matrix_.incident.size() * matrix_.exit.size())
    throw Error("a Klems matrix has " + std::to_string(matrix_.values.size()) + " values for " +
                    std::to_string(matrix_.exit.size()) + " x " +
                    std::to_string(matrix_.incident.size()) + " patches",
                "give one value a pair of patches");
  if (const double share = anisotropy(matrix_); share > largest_anisotropy)
    throw Error("the surface is not isotropic: turning it moves " +
                    std::to_string(std::lround(100 * share)) +
                    " % of the reflected light elsewhere",
                "only isotropic surfaces can be used as a BRDF here");
}

optics::Mueller<double> KlemsTable::at(double /*wavelength_um*/,
                                       const brdf::Geometry<double>& geometry) const {
  optics::Mueller<double> mueller(0.0);
  const double theta_i = std::abs(geometry.theta_i), theta_r = std::abs(geometry.theta_r);
  if (std::cos(theta_i) <= 0 || std::cos(theta_r) <= 0) return mueller;
  const double phi = geometry.phi_r + (geometry.theta_r < 0 ? std::numbers::pi : 0.0);
  const std::size_t ring = matrix_.incident.ring_of(theta_i);
  const std::size_t first = matrix_.incident.first_of(ring);
  const int patches = matrix_.incident.rings()[ring].patches;
  double sum = 0;
  for (int p = 0; p < patches; ++p) {
    const std::size_t incident = first + static_cast<std::size_t>(p);
    const double travels_to = matrix_.incident.patch(incident).phi_centre;
    sum += matrix_.at(matrix_.exit.patch_of(theta_r, travels_to + phi), incident);
  }
  mueller[0][0] = sum / patches;
  return mueller;
}

bool KlemsTable::in_mirror_patch(const brdf::Geometry<double>& geometry) const {
  const KlemsBasis& incident = matrix_.incident;
  const double phi = geometry.phi_r + (geometry.theta_r < 0 ? std::numbers::pi : 0.0);
  const std::size_t first = incident.first_of(incident.ring_of(std::abs(geometry.theta_i)));
  const double travels_to = incident.patch(first).phi_centre;
  return incident.ring_of(std::abs(geometry.theta_i)) ==
             matrix_.exit.ring_of(std::abs(geometry.theta_r)) &&
         matrix_.exit.patch_of(std::abs(geometry.theta_r), travels_to + phi) ==
             matrix_.exit.patch_of(std::abs(geometry.theta_r), travels_to);
}

brdf::ExitBreaks KlemsTable::exit_breaks() const {
  // In units of a full turn: exit patches end at (p + 1/2)/n, and averaging over incident patches
  // turns them by k/m.
  std::set<long> edges;
  constexpr double units = 1 << 24;
  for (const KlemsRing& exit : matrix_.exit.rings())
    for (const KlemsRing& incident : matrix_.incident.rings())
      for (int p = 0; exit.patches > 1 && p < exit.patches; ++p)
        for (int k = 0; k < incident.patches; ++k) {
          const double turn = (p + 0.5) / exit.patches - static_cast<double>(k) / incident.patches;
          edges.insert(std::lround((turn - std::floor(turn)) * units) % static_cast<long>(units));
        }
  brdf::ExitBreaks breaks;
  breaks.theta_r.push_back(0.0);
  for (const KlemsRing& ring : matrix_.exit.rings())
    breaks.theta_r.push_back(std::min(optics::radians(ring.upper_deg), std::numbers::pi / 2));
  for (const long edge : edges)
    breaks.phi_r.push_back(2 * std::numbers::pi * static_cast<double>(edge) / units);
  const double first = breaks.phi_r.empty() ? 0.0 : breaks.phi_r.front();
  if (breaks.phi_r.empty()) breaks.phi_r.push_back(first);
  breaks.phi_r.push_back(first + 2 * std::numbers::pi);
  return breaks;
}

}  // namespace umov::formats
