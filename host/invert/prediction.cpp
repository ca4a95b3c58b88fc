#include "host/invert/prediction.hpp"

#include <cmath>
#include <cstdio>
#include <limits>
#include <span>

#include "host/errors/error.hpp"
#include "host/formats/atomic_file.hpp"
#include "host/formats/content_hash.hpp"
#include "host/formats/h5_header.hpp"
#include "host/formats/hdf5_image.hpp"
#include "host/invert/fitted_model.hpp"
#include "host/invert/layout.hpp"
#include "host/invert/observations.hpp"
#include "host/optics/angles.hpp"

namespace umov::invert {

Prediction predict(const formats::FitResult& fit, const formats::BrdfTable& table) {
  const FittedModel model(fit);
  const auto& p = table.points;
  const double aperture = solid_angle_sr(table);
  // Which factors scale the model and which add to it: decided on the used points, as in the fit.
  bool any_used = false;
  for (const int used : p.used) any_used = any_used || used != 0;
  const Observations data = any_used ? observations(table, fit.floor_relative) : Observations{};
  Prediction out;
  for (std::size_t i = 0; i < p.size(); ++i) {
    if (!model.has_wavelength(p.wavelength_nm[i])) {
      constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
      out.brdf_per_sr.push_back(unknown);
      out.calibrated_per_sr.push_back(unknown);
      out.residual.push_back(unknown);
      continue;
    }
    const std::size_t w = model.wavelength(p.wavelength_nm[i]);
    const double f =
        model.value(w, view_of(p, i, aperture), channel_of(p.polarizer_deg[i], p.analyzer_deg[i]));
    double calibrated = f;
    for (std::size_t k = 0; k < table.factors.size() && k < fit.factors.size(); ++k) {
      const double entry = table.factors[k].per_point[i];
      if (entry == 0) continue;
      bool relative = false;
      for (const Spectrum& spectrum : data.spectra) {
        if (std::abs(spectrum.wavelength_nm - p.wavelength_nm[i]) < 0.01) {
          relative = spectrum.common[k].relative;
        }
      }
      calibrated += fit.factors[k].value * (relative ? f * entry / p.brdf_per_sr[i] : entry);
    }
    out.brdf_per_sr.push_back(f);
    out.calibrated_per_sr.push_back(calibrated);
    const double sigma = std::hypot(p.brdf_u[i], fit.floor_relative * p.brdf_per_sr[i]);
    out.residual.push_back(sigma > 0 ? (p.brdf_per_sr[i] - calibrated) / sigma
                                     : std::numeric_limits<double>::quiet_NaN());
  }
  return out;
}

std::function<double(double, double, double, double, double, double)> brdf_function(
    const formats::FitResult& fit) {
  return
      [model = FittedModel(fit)](double theta_i_deg, double theta_r_deg, double phi_r_deg,
                                 double wavelength_nm, double polarizer_deg, double analyzer_deg) {
        // Light from the other side of the normal: the same plane seen from behind.
        const double side = theta_i_deg < 0 ? -1 : 1;
        View view;
        view.geometry = {optics::radians(side * theta_i_deg), optics::radians(side * theta_r_deg),
                         optics::radians(phi_r_deg)};
        return model.value(model.wavelength(wavelength_nm), view,
                           channel_of(polarizer_deg, analyzer_deg));
      };
}

Hemisphere hemisphere(const formats::FitResult& fit, double wavelength_nm, double theta_i_deg,
                      double theta_step_deg, double phi_step_deg) {
  if (!(theta_i_deg >= 0 && theta_i_deg < 90)) {
    throw Error("incidence " + wavelength_text(theta_i_deg) + " degrees is not in 0 … 90",
                "give the angle from the surface normal");
  }
  if (!(theta_step_deg > 0 && theta_step_deg <= 90 && phi_step_deg > 0 && phi_step_deg <= 360)) {
    throw Error("the steps of the hemisphere's grid must be positive", "use 2 and 5 degrees");
  }
  const FittedModel model(fit);
  const std::size_t w = model.wavelength(wavelength_nm);
  Hemisphere out;
  out.wavelength_nm = fit.wavelengths_nm[w];
  out.theta_i_deg = theta_i_deg;
  for (double t = 0; t < 90 - theta_step_deg / 2; t += theta_step_deg) out.theta_r_deg.push_back(t);
  for (double p = 0; p < 360 - phi_step_deg / 2; p += phi_step_deg) out.phi_r_deg.push_back(p);
  for (const double theta_r : out.theta_r_deg) {
    for (const double phi_r : out.phi_r_deg) {
      const View view{
          {optics::radians(theta_i_deg), optics::radians(theta_r), optics::radians(phi_r)}};
      double f = 0;
      const double u = model.sigma(w, view, channel_unpolarized(), f);
      out.brdf_per_sr.push_back(f);
      out.brdf_u.push_back(u);
    }
  }
  return out;
}

void write_hemispheres_csv(const std::string& path, const std::vector<Hemisphere>& parts) {
  std::string text = "wavelength_nm,theta_i_deg,theta_r_deg,phi_r_deg,brdf_per_sr,brdf_u\n";
  char line[160];
  for (const Hemisphere& h : parts) {
    for (std::size_t r = 0; r < h.theta_r_deg.size(); ++r) {
      for (std::size_t p = 0; p < h.phi_r_deg.size(); ++p) {
        const std::size_t i = r * h.phi_r_deg.size() + p;
        std::snprintf(line, sizeof line, "%g,%g,%g,%g,%.8g,%.4g\n", h.wavelength_nm, h.theta_i_deg,
                      h.theta_r_deg[r], h.phi_r_deg[p], h.brdf_per_sr[i], h.brdf_u[i]);
        text += line;
      }
    }
  }
  formats::replace_file(path, text);
}

void write_hemispheres_hdf5(const std::string& path, const std::vector<Hemisphere>& parts,
                            const formats::Provenance& provenance,
                            const std::vector<std::pair<std::string, std::string>>& keys) {
  constexpr const char* format_name = "umov hemisphere h5";
  formats::check_storable(keys, path);
  formats::ContentHash hash;
  hash.text(format_name);
  hash.pairs("header", keys);
  for (const Hemisphere& h : parts) {
    hash.column("wavelength_nm", std::span(&h.wavelength_nm, 1));
    hash.column("theta_i_deg", std::span(&h.theta_i_deg, 1));
    hash.column("theta_r_deg", h.theta_r_deg);
    hash.column("phi_r_deg", h.phi_r_deg);
    hash.column("brdf_per_sr", h.brdf_per_sr);
    hash.column("brdf_u", h.brdf_u);
  }
  formats::Hdf5Builder file(path);
  formats::write_h5_header(file, format_name, keys, provenance, hash.hex_digest());
  for (const Hemisphere& h : parts) {
    std::string group =
        "/hemisphere_" + wavelength_text(h.wavelength_nm) + "_" + wavelength_text(h.theta_i_deg);
    file.group(group);
    group += "/";
    const std::size_t rows = h.theta_r_deg.size(), columns = h.phi_r_deg.size();
    file.column(group + "wavelength_nm", std::span(&h.wavelength_nm, 1), "nm");
    file.column(group + "theta_i_deg", std::span(&h.theta_i_deg, 1), "deg");
    file.column(group + "theta_r_deg", h.theta_r_deg, "deg");
    file.column(group + "phi_r_deg", h.phi_r_deg, "deg");
    file.matrix(group + "brdf_per_sr", h.brdf_per_sr, rows, columns, "1/sr");
    file.matrix(group + "brdf_u", h.brdf_u, rows, columns, "1/sr");
  }
  formats::replace_file(path, file.finish());
}

}  // namespace umov::invert
