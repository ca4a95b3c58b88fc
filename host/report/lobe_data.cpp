// The fitted BRDF over the hemisphere, for the lobe and the map.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/optics/angles.hpp"
#include "host/report/json_parts.hpp"
#include "host/report/numbers.hpp"

namespace umov::report {

namespace {

constexpr std::size_t most_incidences = 6;
constexpr std::size_t most_wavelengths = 6;
constexpr double horizon_deg = 88.0;

/// At most `most` entries, first and last among them, evenly spread.
std::vector<std::size_t> spread(std::size_t count, std::size_t most) {
  std::vector<std::size_t> out;
  if (count <= most) {
    for (std::size_t i = 0; i < count; ++i) out.push_back(i);
    return out;
  }
  for (std::size_t i = 0; i < most; ++i) out.push_back(i * (count - 1) / (most - 1));
  return out;
}

/// Polar angles, close together about the mirror direction where a gloss lobe is a degree wide.
std::vector<double> polar_nodes(double theta_i_deg) {
  std::vector<double> nodes;
  for (double theta = 0; theta < horizon_deg; theta += 4) nodes.push_back(theta);
  for (const double off : {0.0, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 5.5, 7.0, 9.0, 12.0})
    for (const double sign : {-1.0, 1.0}) nodes.push_back(theta_i_deg + sign * off);
  nodes.push_back(86);
  nodes.push_back(horizon_deg);
  std::sort(nodes.begin(), nodes.end());
  std::vector<double> out;
  for (const double node : nodes)
    if (node >= 0 && node <= horizon_deg && (out.empty() || node - out.back() > 0.3))
      out.push_back(node);
  return out;
}

/// Azimuths 0 … 180°; near normal incidence no azimuth is special.
std::vector<double> azimuth_nodes(double theta_i_deg) {
  std::vector<double> out;
  if (theta_i_deg < 1) {
    for (int phi = 0; phi <= 180; phi += 10) out.push_back(phi);
    return out;
  }
  const double stretch = std::clamp(0.5 / std::sin(optics::radians(theta_i_deg)), 0.6, 4.0);
  for (const double phi : {0.0, 0.7, 1.5, 2.5, 3.5, 5.0, 7.0, 9.0, 12.0, 16.0, 21.0})
    if (phi * stretch < 30) out.push_back(phi * stretch);
  for (int phi = 30; phi <= 180; phi += 10) out.push_back(phi);
  return out;
}

}  // namespace

Json lobe(const SampleView& view) {
  if (!view.model) return nullptr;
  Json grids = Json::array(), wavelengths = Json::array();
  const auto chosen = spread(view.fit->wavelengths_nm.size(), most_wavelengths);
  // The names under which the rest of the page knows these wavelengths.
  const auto label = [&](std::size_t w) {
    return view.wavelengths_nm[nearest(view.wavelengths_nm, view.fit->wavelengths_nm[w])];
  };
  for (const std::size_t w : chosen) wavelengths.push_back(label(w));
  double largest_mirror = 0, lowest = INFINITY, highest = 0;
  for (const std::size_t t : spread(view.theta_i_deg.size(), most_incidences)) {
    const double theta_i = view.theta_i_deg[t];
    const auto theta = polar_nodes(theta_i);
    const auto phi = azimuth_nodes(theta_i);
    Json brdf = Json::object(), dolp = Json::object();
    for (const std::size_t w : chosen) {
      std::vector<double> f, p;
      for (const double theta_r : theta) {
        for (const double phi_r : phi) {
          const MuellerRows m = view.model->mueller(w, theta_i, theta_r, phi_r);
          f.push_back(m[0]);
          if (theta_r < 80 && m[0] > 0)
            lowest = std::min(lowest, m[0]), highest = std::max(highest, m[0]);
          p.push_back(linear_polarisation(m));
        }
      }
      const std::string name = fmt::format("{}", label(w));
      brdf[name] = rounded(f, 4);
      dolp[name] = rounded(p, 3);
      largest_mirror = std::max(largest_mirror, view.model->mirror_reflectance(w, theta_i));
    }
    grids.push_back({{"theta_i_deg", theta_i},
                     {"theta_deg", rounded(theta)},
                     {"phi_deg", rounded(phi)},
                     {"brdf", std::move(brdf)},
                     {"dolp", std::move(dolp)}});
  }
  std::string note;
  if (largest_mirror > 1e-6)
    note = "A smooth share of the surface also reflects up to " + plain(100 * largest_mirror, 2) +
           " % of the light exactly into the mirror direction.";
  return {{"wavelengths_nm", wavelengths},
          {"grids", std::move(grids)},
          {"note", note},
          {"log", highest > 4 * lowest}};
}

}  // namespace umov::report
