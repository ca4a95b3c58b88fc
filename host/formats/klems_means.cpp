#include "host/formats/klems_means.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "host/brdf/table_dhr.hpp"
#include "host/formats/spread.hpp"
#include "host/formats/table_file.hpp"
#include "host/formats/visible_band.hpp"

namespace umov::formats {
namespace {

constexpr double pi = std::numbers::pi;
constexpr std::size_t fewest_points = 1024;
constexpr double settled = 1e-3;
constexpr double negligible_share = 1e-6;

/// Polar angle below which `share` of the patch's projected solid angle lies.
double polar_angle(const KlemsPatch& patch, double share) {
  const double low = std::sin(patch.theta_lower), high = std::sin(patch.theta_upper);
  return std::asin(std::sqrt(low * low + (high * high - low * low) * share));
}

double azimuth(const KlemsPatch& patch, double share) {
  return patch.phi_centre + patch.phi_half_width * (2 * share - 1);
}

}  // namespace

KlemsMeans::KlemsMeans(const brdf::Table& source, KlemsBasis basis,
                       const std::vector<double>& wavelengths_um, std::size_t most_points)
    : source_(source),
      basis_(std::move(basis)),
      wavelengths_um_(wavelengths_um),
      most_points_(most_points) {
  const std::vector<double> shares = visible_shares(wavelengths_um);
  for (std::size_t n = 0; n < shares.size(); ++n)
    if (shares[n] > negligible_share) bands_.emplace_back(wavelengths_um[n], shares[n]);
}

optics::Mueller<double> KlemsMeans::at(double /*wavelength_um*/,
                                       const brdf::Geometry<double>& geometry) const {
  optics::Mueller<double> mueller(0.0);
  const double theta_i = std::abs(geometry.theta_i), theta_r = std::abs(geometry.theta_r);
  if (std::cos(theta_i) <= 0 || std::cos(theta_r) <= 0) return mueller;
  const double phi = geometry.phi_r + (geometry.theta_r < 0 ? pi : 0.0);
  const std::size_t ring = basis_.ring_of(theta_i), first = basis_.first_of(ring);
  const auto patches = static_cast<std::size_t>(basis_.rings()[ring].patches);
  double sum = 0;
  for (std::size_t incident = first; incident < first + patches; ++incident)
    sum += mean_of(incident, basis_.patch_of(theta_r, basis_.patch(incident).phi_centre + phi));
  mueller[0][0] = sum / static_cast<double>(patches);
  return mueller;
}

double KlemsMeans::mean_of(std::size_t incident, std::size_t exit) const {
  const KlemsPatch& from = basis_.patch(incident);
  const KlemsPatch& to = basis_.patch(exit);
  const long ni = basis_.rings()[from.ring].patches, no = basis_.rings()[to.ring].patches;
  const auto place = [&](std::size_t patch, const KlemsPatch& of) {
    return static_cast<long>(patch - basis_.first_of(of.ring));
  };
  const long whole = ni * no;
  const long turn = ((place(exit, to) * ni - place(incident, from) * no) % whole + whole) % whole;
  const std::tuple key{from.ring, to.ring, std::min(turn, whole - turn)};
  {
    const std::lock_guard lock(guard_);
    if (const auto found = known_.find(key); found != known_.end()) return found->second;
  }
  double value = sampled(from, to);
  if (from.ring == to.ring && turn == 0) {
    constexpr int steps = 32;
    for (int s = 0; s < steps; ++s)
      value += mirror(polar_angle(from, (s + 0.5) / steps)) / steps / to.projected_solid_angle();
  }
  const std::lock_guard lock(guard_);
  return known_.emplace(key, value).first->second;
}

double KlemsMeans::sampled(const KlemsPatch& incident, const KlemsPatch& exit) const {
  double sum = 0, before = 0;
  std::size_t n = 0;
  for (std::size_t points = fewest_points;; points *= 2) {
    for (; n < points; ++n) {
      const double theta_i = polar_angle(incident, spread(n + 1, 2));
      const double theta_r = polar_angle(exit, spread(n + 1, 3));
      const double phi = azimuth(exit, spread(n + 1, 5)) - azimuth(incident, spread(n + 1, 7));
      for (const auto& [um, share] : bands_)
        sum += share * source_.at(um, {theta_i, theta_r, std::remainder(phi, 2 * pi)})[0][0];
    }
    const double mean = sum / static_cast<double>(n);
    const bool steady = n > fewest_points && std::abs(mean - before) <= settled * mean;
    if (steady || points >= most_points_) return mean;
    before = mean;
  }
}

double KlemsMeans::mirror(double theta_i) const {
  const auto* model = dynamic_cast<const ModelTable*>(&source_);
  double sum = 0;
  for (const auto& [um, share] : bands_) sum += model ? share * model->mirror(um, theta_i) : 0.0;
  return sum;
}

double KlemsMeans::reflectance(double theta_i) const {
  // Reflectance is smooth over a ring: three nodes of Gauss do.
  constexpr std::array<std::pair<double, double>, 3> nodes{
      {{0.1127016653792583, 5.0 / 18}, {0.5, 8.0 / 18}, {0.8872983346207417, 5.0 / 18}}};
  constexpr double accuracy = 1e-4;
  constexpr int most_divisions = 512;
  const auto* model = dynamic_cast<const ModelTable*>(&source_);
  const KlemsPatch& patch = basis_.patch(basis_.first_of(basis_.ring_of(std::abs(theta_i))));
  double sum = 0;
  for (const auto& [at, weight] : nodes) {
    const double theta = polar_angle(patch, at);
    double scattered = 0;
    for (const auto& [um, share] : bands_)
      scattered +=
          share *
          (model ? model->dhr(um, theta)
                 : brdf::integrate_table(source_, um, theta, accuracy, most_divisions).value[0]);
    sum += weight * (scattered + mirror(theta));
  }
  return sum;
}

}  // namespace umov::formats
