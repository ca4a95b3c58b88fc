#include "host/surface/hemisphere_table.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/errors/error.hpp"
#include "host/optics/angles.hpp"
#include "host/optics/frames.hpp"
#include "host/optics/mueller.hpp"

namespace umov::surface {
namespace {

using optics::Mueller;

// As a mirror at the plane of incidence shows it: U and V change sign.
Mueller<double> mirrored(Mueller<double> m) {
  for (int c = 0; c < 4; ++c) {
    for (int r = 0; r < 4; ++r) {
      if ((r < 2) != (c < 2)) m[c][r] = -m[c][r];
    }
  }
  return m;
}

}  // namespace

brdf::GridTable hemisphere_table(const std::vector<trace::Result>& results,
                                 const std::vector<double>& theta_i_deg,
                                 const std::vector<double>& wavelengths_um,
                                 const std::string& origin) {
  if (results.empty() || results.size() != theta_i_deg.size() ||
      !std::is_sorted(theta_i_deg.begin(), theta_i_deg.end(), std::less_equal<>())) {
    throw Error("the angles of incidence of a table must rise, with one simulation each",
                "name them in ascending order, each once");
  }
  const trace::Hemisphere& hemisphere = results.front().hemisphere();
  brdf::GridAxes axes{theta_i_deg, {}, {}, wavelengths_um};
  for (std::size_t cell = 0; cell < hemisphere.cells(); ++cell) {
    const trace::Cell c = hemisphere.cell(cell);
    const double middle = optics::degrees(0.5 * (c.theta_low + c.theta_high));
    if (axes.theta_r_deg.empty() || middle > axes.theta_r_deg.back() + 1e-9) {
      axes.theta_r_deg.push_back(middle);
    }
  }
  const std::size_t steps = 2 * axes.theta_r_deg.size();
  for (std::size_t i = 0; i <= steps; ++i) {
    axes.phi_r_deg.push_back(180.0 * static_cast<double>(i) / static_cast<double>(steps));
  }
  std::vector<double> values;
  for (std::size_t w = 0; w < wavelengths_um.size(); ++w) {
    for (const trace::Result& result : results) {
      for (const double theta_r : axes.theta_r_deg) {
        for (const double phi : axes.phi_r_deg) {
          const auto seen = [&](double azimuth) {
            const std::size_t cell = hemisphere.find(
                optics::exit_direction(optics::radians(theta_r), optics::radians(azimuth)));
            return result.brdf(cell, w).mean;
          };
          Mueller<double> m = 0.5 * (seen(phi) + mirrored(seen(-phi)));
          if (phi == 0.0 || phi == 180.0) m = 0.5 * (m + mirrored(m));
          for (int e = 0; e < 16; ++e) values.push_back(optics::element(m, e / 4, e % 4));
        }
      }
    }
  }
  return {std::move(axes), std::move(values), 16, origin};
}

}  // namespace umov::surface
