// Looking things up in a reduced measurement, and holding a fit against the truth.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/cli/emulator/truth.hpp"
#include "host/formats/brdf_table.hpp"
#include "host/formats/fit_file.hpp"

namespace umov::study {

/// Points of one curve in ascending θr; unusable ones are left out.
struct Curve {
  std::vector<double> theta_r_deg, value, u;
};

/// BRDF for unpolarised light without analyser, 1/sr: the mean of P and S incidence, in plane. `u`
/// is the independent part. Points at which one of them lacks are left out.
Curve unpolarised_curve(const formats::BrdfTable& table, double wavelength_nm, double theta_i_deg);
/// BRDF of one state, in plane.
Curve state_curve(const formats::BrdfTable& table, double wavelength_nm, double theta_i_deg,
                  double polarizer_deg, double analyzer_deg);
/// DOLP for P-polarised light (P4), in plane.
Curve dolp_curve(const formats::BrdfTable& table, double wavelength_nm, double theta_i_deg);

struct Reflectance {
  double value = 0, u = 0;
};
/// DHR at normal incidence as reduced; nullopt where there is none.
std::optional<Reflectance> normal_dhr(const formats::BrdfTable& table, double wavelength_nm);

/// Errors of a fitted model over the whole hemisphere, for unpolarised light.
struct HemisphereError {
  double wavelength_nm = 0, theta_i_deg = 0;
  std::size_t directions = 0;  ///< where the truth is above 1 % of its peak
  double median = 0, p90 = 0, max = 0;
  double max_theta_r_deg = 0, max_phi_r_deg = 0;  ///< where the largest is; of one part only
  std::vector<double> all;                        ///< sizes of the relative errors
};

/// θr 0 to 88 deg by 1, φ 0 to 180 deg by 3, and .25 deg by 1 deg about the mirror direction, so
/// that a narrow lobe has its directions. `share` of the peak counts.
HemisphereError hemisphere_error(const formats::FitResult& fit, const emulator::SampleTruth& truth,
                                 double wavelength_nm, double theta_i_deg, double share = 0.01);

/// Median, 90th percentile and maximum of several lists together.
HemisphereError together(const std::vector<HemisphereError>& parts);

/// The model's BRDF for unpolarised light at directions, 1/sr.
std::vector<double> model_brdf(const formats::FitResult& fit, double wavelength_nm,
                               double theta_i_deg, const std::vector<double>& theta_r_deg,
                               const std::vector<double>& phi_r_deg);

}  // namespace umov::study
