#include "host/surface/brdf_export.hpp"

#include <cmath>

#include "host/formats/scan_table.hpp"
#include "host/formats/table_csv_rows.hpp"
#include "host/optics/realisability.hpp"

namespace umov::surface {

formats::BrdfTable brdf_table(const trace::Result& result, const trace::Scene& scene,
                              double theta_i_deg, Directions directions) {
  formats::BrdfTable table;
  auto& points = table.points;
  auto& mueller = table.mueller.emplace();
  mueller.side = 4;
  const trace::Hemisphere& hemisphere = result.hemisphere();
  const std::size_t first = directions == Directions::strip ? hemisphere.cells() : 0;
  const std::size_t last = directions == Directions::cells ? hemisphere.cells() : hemisphere.size();
  for (std::size_t w = 0; w < scene.wavelengths_um.size(); ++w) {
    const double wavelength_nm = formats::nanometres(scene.wavelengths_um[w]);
    for (std::size_t index = first; index < last; ++index) {
      const trace::MuellerEstimate e = result.brdf(index, w);
      if (!(e.mean[0][0] > 0.0 && e.error[0][0] > 0.0)) continue;
      const trace::Cell cell = hemisphere.cell(index);
      const double theta_r = optics::degrees(0.5 * (cell.theta_low + cell.theta_high));
      const double phi =
          std::remainder(optics::degrees(0.5 * (cell.phi_low + cell.phi_high)), 360.0);
      for (auto* group : {&points.theta_i_deg, &mueller.theta_i_deg}) group->push_back(theta_i_deg);
      for (auto* group : {&points.theta_r_deg, &mueller.theta_r_deg}) group->push_back(theta_r);
      for (auto* group : {&points.phi_r_deg, &mueller.phi_r_deg}) group->push_back(phi);
      for (auto* group : {&points.wavelength_nm, &mueller.wavelength_nm}) {
        group->push_back(wavelength_nm);
      }
      points.polarizer_deg.push_back(formats::open_axis);
      points.analyzer_deg.push_back(formats::open_axis);
      points.brdf_per_sr.push_back(e.mean[0][0]);
      points.brdf_u.push_back(e.error[0][0]);
      points.used.push_back(1);

      std::array<double, 16> elements{};
      for (std::size_t i = 0; i < 16; ++i) {
        const int row = static_cast<int>(i / 4);
        const int column = static_cast<int>(i % 4);
        elements[i] = optics::element(e.mean, row, column);
        mueller.mueller.push_back(elements[i]);
        mueller.mueller_u.push_back(optics::element(e.error, row, column));
      }
      // A direct estimate: every element by itself, nothing overdetermined.
      mueller.condition.push_back(1.0);
      mueller.chi2.push_back(0.0);
      mueller.dof.push_back(0.0);
      const auto realisable = optics::realisability(elements);
      double variance = 0.0;
      for (std::size_t i = 0; i < 16; ++i) {
        const double part = realisable.slope[i] * optics::element(e.error, static_cast<int>(i / 4),
                                                                  static_cast<int>(i % 4));
        variance += part * part;
      }
      mueller.realisable_z.push_back(
          variance > 0.0 ? realisable.least_eigenvalue / std::sqrt(variance) : 0.0);
    }
    const trace::MuellerEstimate all = result.hemispherical(w);
    table.dhr.wavelength_nm.push_back(wavelength_nm);
    table.dhr.theta_i_deg.push_back(theta_i_deg);
    table.dhr.dhr.push_back(all.mean[0][0]);
    table.dhr.dhr_u.push_back(all.error[0][0]);
  }
  return table;
}

}  // namespace umov::surface
