#include "host/formats/dense_grid.hpp"

#include <algorithm>

#include "host/optics/angles.hpp"
#include "host/optics/mueller.hpp"

namespace umov::formats {

brdf::GridTable dense_grid(const brdf::Table& table, std::vector<double> wavelengths_um,
                           const std::function<void(double, double)>& progress) {
  brdf::GridAxes axes;
  for (int i = 0; i <= 35; ++i) axes.theta_i_deg.push_back(2.5 * i);
  for (int i = 0; i <= 89; ++i) axes.theta_r_deg.push_back(i);
  for (double phi = 0.0; phi < 180.0; phi += phi < 10.0 ? 1.0 : phi < 30.0 ? 2.0 : 5.0)
    axes.phi_r_deg.push_back(phi);
  axes.phi_r_deg.push_back(180.0);
  axes.wavelength_um = std::move(wavelengths_um);
  const bool polarised = table.polarised();
  const int elements = polarised ? 16 : 1;
  std::vector<double> values;
  values.reserve(axes.wavelength_um.size() * axes.theta_i_deg.size() * axes.theta_r_deg.size() *
                 axes.phi_r_deg.size() * static_cast<std::size_t>(elements));
  double done = 0.0;
  const double total =
      static_cast<double>(axes.wavelength_um.size()) * static_cast<double>(axes.theta_i_deg.size());
  for (const double um : axes.wavelength_um)
    for (const double theta_i : axes.theta_i_deg) {
      for (const double theta_r : axes.theta_r_deg)
        for (const double phi : axes.phi_r_deg) {
          brdf::Geometry<double> g{optics::radians(theta_i), optics::radians(theta_r),
                                   optics::radians(phi)};
          const auto m = table.at(um, g);
          if (polarised) {
            for (int k = 0; k < elements; ++k) values.push_back(optics::element(m, k / 4, k % 4));
            continue;
          }
          g.phi_r = -g.phi_r;
          values.push_back(0.5 *
                           (optics::element(m, 0, 0) + optics::element(table.at(um, g), 0, 0)));
        }
      if (progress) progress(done += 1.0, total);
    }
  return {std::move(axes), std::move(values), elements, table.description()};
}

}  // namespace umov::formats
