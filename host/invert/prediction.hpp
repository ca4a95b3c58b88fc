// What a fitted model says: at the measured points, over the hemisphere, and integrated.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "host/formats/brdf_table.hpp"
#include "host/formats/fit_file.hpp"
#include "host/formats/provenance.hpp"

namespace umov::invert {

/// One entry a point of the table, used or not.
struct Prediction {
  std::vector<double> brdf_per_sr;        ///< the model, without the calibration factors
  std::vector<double> calibrated_per_sr;  ///< the same with the fitted factors applied: what a
                                          ///< point should read
  std::vector<double> residual;           ///< (measured − calibrated)/uncertainty, NaN where the
                                          ///< uncertainty is not positive
};
/// Points at wavelengths that were not fitted get NaN.
Prediction predict(const formats::FitResult& fit, const formats::BrdfTable& table);

/// The fitted BRDF as a function of θi, θr (signed in plane), φr in degrees, wavelength in nm and
/// the axes of polariser and analyser in degrees (open_axis = open); 1/sr, without the mirror part.
/// Throws umov::Error, when called, for a wavelength that was not fitted.
std::function<double(double theta_i_deg, double theta_r_deg, double phi_r_deg, double wavelength_nm,
                     double polarizer_deg, double analyzer_deg)>
brdf_function(const formats::FitResult& fit);

/// BRDF for unpolarised light over the exit hemisphere. Arrays run over theta_r first, then phi_r:
/// entry r * phi_r_deg.size() + p.
struct Hemisphere {
  double wavelength_nm = 0, theta_i_deg = 0;
  std::vector<double> theta_r_deg, phi_r_deg;
  std::vector<double> brdf_per_sr;
  std::vector<double> brdf_u;  ///< one sigma, from the fit's covariance
};
/// Grid of equal steps: theta_r 0 … 90 − theta_step/2 (the horizon itself is left out), phi_r
/// 0 … 360 − phi_step. Steps and angle in degrees.
Hemisphere hemisphere(const formats::FitResult& fit, double wavelength_nm, double theta_i_deg,
                      double theta_step_deg = 2, double phi_step_deg = 5);

/// CSV with columns wavelength_nm, theta_i_deg, theta_r_deg, phi_r_deg, brdf_per_sr, brdf_u.
void write_hemispheres_csv(const std::string& path, const std::vector<Hemisphere>& parts);
/// HDF5 with the header of all files (format "umov hemisphere h5", provenance, checksum; `keys`
/// such as data_sha256 in /header and as root attributes): group /hemisphere_<nm>_<theta_i> for
/// each part with wavelength_nm[1], theta_i_deg[1], theta_r_deg[r], phi_r_deg[p], brdf_per_sr[r,p],
/// brdf_u[r,p], units as attributes.
void write_hemispheres_hdf5(const std::string& path, const std::vector<Hemisphere>& parts,
                            const formats::Provenance& provenance,
                            const std::vector<std::pair<std::string, std::string>>& keys);

}  // namespace umov::invert
