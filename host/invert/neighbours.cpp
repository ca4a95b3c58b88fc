#include "host/invert/neighbours.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>

#include "host/brdf/facet.hpp"
#include "host/optics/angles.hpp"

namespace umov::invert {
namespace {

constexpr std::size_t neighbours = 4;
/// Nearer than this two directions are one, radians.
constexpr double same_direction = 1e-3;

struct Place {
  double theta_h = 0, theta_d = 0;
};

Place place_of(const formats::BrdfTable::Points& p, std::size_t i) {
  const auto frame = brdf::facet_frame(brdf::Geometry<double>{optics::radians(p.theta_i_deg[i]),
                                                              optics::radians(p.theta_r_deg[i]),
                                                              optics::radians(p.phi_r_deg[i])});
  return {std::atan(std::sqrt(frame.tan2_h)), std::atan2(frame.sin_d, frame.cos_d)};
}

long rounded(double value) {
  return std::isnan(value) ? std::numeric_limits<long>::max() : std::lround(value * 1000);
}

}  // namespace

std::vector<double> from_neighbours(const formats::BrdfTable& table, const std::vector<bool>& known,
                                    const std::vector<bool>& wanted) {
  const auto& p = table.points;
  using Kind = std::tuple<long, long, long>;
  const auto kind = [&](std::size_t i) {
    return Kind{rounded(p.wavelength_nm[i]), rounded(p.polarizer_deg[i]),
                rounded(p.analyzer_deg[i])};
  };
  std::map<Kind, std::vector<std::pair<Place, std::size_t>>> groups;
  for (std::size_t i = 0; i < p.size(); ++i) {
    if (known[i] && p.brdf_per_sr[i] > 0) groups[kind(i)].emplace_back(place_of(p, i), i);
  }
  std::vector<double> out(p.size(), 0.0);
  for (std::size_t i = 0; i < p.size(); ++i) {
    if (!wanted[i]) continue;
    out[i] = std::numeric_limits<double>::quiet_NaN();
    const auto group = groups.find(kind(i));
    if (group == groups.end()) continue;
    const Place here = place_of(p, i);
    std::vector<std::pair<double, std::size_t>> near;
    for (const auto& [place, j] : group->second) {
      if (j == i) continue;
      const double d = std::hypot(place.theta_h - here.theta_h, place.theta_d - here.theta_d);
      near.emplace_back(std::max(d, same_direction), j);
    }
    if (near.empty()) continue;
    const std::size_t count = std::min(neighbours, near.size());
    std::partial_sort(near.begin(), near.begin() + static_cast<std::ptrdiff_t>(count), near.end());
    double sum = 0, weights = 0;
    for (std::size_t n = 0; n < count; ++n) {
      const double weight = 1 / (near[n].first * near[n].first);
      sum += weight * std::log(p.brdf_per_sr[near[n].second]);
      weights += weight;
    }
    out[i] = std::exp(sum / weights);
  }
  return out;
}

}  // namespace umov::invert
