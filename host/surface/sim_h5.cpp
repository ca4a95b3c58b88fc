#include "host/surface/sim_h5.hpp"

#include <cmath>
#include <vector>

#include "host/formats/table_csv_rows.hpp"
#include "host/optics/angles.hpp"
#include "host/optics/mueller.hpp"
#include "host/surface/radiance.hpp"

namespace umov::surface {
namespace {

// Cells [first, last) of the hemisphere.
void add_cells(formats::Hdf5Builder& file, const std::string& path, const trace::Result& result,
               const trace::Scene& scene, std::size_t first, std::size_t last) {
  const std::size_t wavelengths = scene.wavelengths_um.size();
  std::vector<double> theta, phi, solid, nm, mueller, errors;
  for (const double w : scene.wavelengths_um) nm.push_back(formats::nanometres(w));
  for (std::size_t i = first; i < last; ++i) {
    const trace::Cell cell = result.hemisphere().cell(i);
    theta.push_back(optics::degrees(0.5 * (cell.theta_low + cell.theta_high)));
    phi.push_back(std::remainder(optics::degrees(0.5 * (cell.phi_low + cell.phi_high)), 360.0));
    solid.push_back(cell.solid_angle);
    for (std::size_t w = 0; w < wavelengths; ++w) {
      const trace::MuellerEstimate e = result.brdf(i, w);
      for (int k = 0; k < 16; ++k) {
        mueller.push_back(optics::element(e.mean, k / 4, k % 4));
        errors.push_back(optics::element(e.error, k / 4, k % 4));
      }
    }
  }
  file.column(path + "/theta_r_deg", std::span<const double>(theta), "deg");
  file.column(path + "/phi_r_deg", std::span<const double>(phi), "deg");
  file.column(path + "/solid_angle_sr", std::span<const double>(solid), "sr");
  file.column(path + "/wavelength_nm", std::span<const double>(nm), "nm");
  const std::vector<std::size_t> shape{last - first, wavelengths, 16};
  file.array(path + "/mueller", mueller, shape, "1/sr");
  file.array(path + "/mueller_se", errors, shape, "1/sr");
}

}  // namespace

void add_hemisphere(formats::Hdf5Builder& file, const std::string& path,
                    const trace::Result& result, const trace::Scene& scene,
                    const Simulated& simulated, const std::optional<Emission>& emission) {
  file.group(path);
  const std::size_t cells = result.hemisphere().cells();
  add_cells(file, path, result, scene, 0, cells);
  if (result.hemisphere().size() > cells) {
    file.group(path + "/strip");
    add_cells(file, path + "/strip", result, scene, cells, result.hemisphere().size());
  }
  const trace::Ledger& ledger = result.ledger();
  std::vector<double> dhr, dhr_se, dop, dop_se, absorbed, lost;
  for (std::size_t w = 0; w < scene.wavelengths_um.size(); ++w) {
    const trace::MuellerEstimate all = result.hemispherical(w);
    const trace::Estimate polarised = result.hemispherical_dop(w);
    dhr.push_back(all.mean[0][0]);
    dhr_se.push_back(all.error[0][0]);
    dop.push_back(polarised.mean);
    dop_se.push_back(polarised.error);
    absorbed.push_back(ledger.absorbed[w] / ledger.launched[w]);
    lost.push_back((ledger.lost[w] + ledger.below[w]) / ledger.launched[w]);
  }
  const auto set = [&](const char* name, const std::vector<double>& values) {
    file.attribute(path, name, std::span<const double>(values));
  };
  set("theta_i_deg", {simulated.theta_i_deg});
  set("dhr", dhr);
  set("dhr_se", dhr_se);
  set("hemispherical_dop", dop);
  set("hemispherical_dop_se", dop_se);
  set("absorbed", absorbed);
  set("lost", lost);
  set("rays", {static_cast<double>(ledger.rays)});
  set("samples", {static_cast<double>(result.samples())});
  set("seed", {static_cast<double>(simulated.seed)});
  set("lays", {static_cast<double>(simulated.lays)});
  if (!emission || !result.knows_absorptance()) return;

  const std::string radiance = path + "/radiance";
  file.group(radiance);
  const auto bands = viewed_radiance(result, scene, *emission);
  const auto column = [&](const std::string& name, double ViewedRadiance::*member,
                          const char* unit) {
    std::vector<double> values;
    for (const ViewedRadiance& band : bands) values.push_back(band.*member);
    file.column(radiance + "/" + name, std::span<const double>(values), unit);
  };
  constexpr const char* unit = "W/m^2/sr/um";
  column("wavelength_um", &ViewedRadiance::wavelength_um, "um");
  column("emissivity", &ViewedRadiance::emissivity, "1");
  column("emissivity_u", &ViewedRadiance::emissivity_u, "1");
  column("emitted", &ViewedRadiance::emitted, unit);
  column("emitted_u", &ViewedRadiance::emitted_u, unit);
  column("reflected_sky", &ViewedRadiance::reflected_sky, unit);
  column("reflected_sun", &ViewedRadiance::reflected_sun, unit);
  column("reflected_sun_u", &ViewedRadiance::reflected_sun_u, unit);
  column("total", &ViewedRadiance::total, unit);
  column("total_u", &ViewedRadiance::total_u, unit);
  column("stokes_1", &ViewedRadiance::stokes_1, unit);
}

}  // namespace umov::surface
