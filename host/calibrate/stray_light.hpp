// Light that reaches the detector past the sample: it goes with the power and stays when the sample
// is taken away, where the dark signal stays with the shutter closed.
//
// Level as BRDF cosθr, unpolarised: L_λ + F_λ exp(-α²/2w²), α the angle of the exit direction to
// forward grazing (+x). A record without a sample is
//     X cosφ + Y sinφ = dark + C (L + F exp(-α²/2w²)) a ΔΩ monitor,   a = 1, or ½ behind an
//     analyser.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "host/calibrate/gain_range.hpp"

namespace umov::calibrate {

struct StrayLight {
  std::vector<double> wavelength_nm;   ///< ascending
  std::vector<double> even_per_sr;     ///< L, in the order of the wavelengths
  std::vector<double> forward_per_sr;  ///< F
  double forward_width_deg = 10;       ///< w
  std::vector<int> measured;           ///< 1: records without a sample stand behind it
  /// Of L of all wavelengths, then F of all wavelengths: the dark signal couples them.
  Eigen::MatrixXd covariance;
  std::size_t records = 0;
  double chi2 = 0, dof = 0;

  bool empty() const { return wavelength_nm.empty(); }
  /// Place of a wavelength within 0.5 nm; -1 where there is none.
  Eigen::Index number(double wavelength_nm) const;
  /// Share of F that a direction gets.
  double forward_share(double theta_r_deg, double phi_r_deg) const;
  /// L + F share in 1/sr; 0 for an unknown wavelength.
  double level(double wavelength_nm, double theta_r_deg, double phi_r_deg) const;
  double level_u(double wavelength_nm, double theta_r_deg, double phi_r_deg) const;
  /// Column k: shift of all L and F for one standard deviation of the k-th independent cause.
  Eigen::MatrixXd shifts() const;
  /// Shift of the level for one column of `shifts()`.
  double level_shift(const Eigen::VectorXd& column, double wavelength_nm, double theta_r_deg,
                     double phi_r_deg) const;
};

/// Share of stray light that passes the analyser (formats::open_axis = none in the beam).
double stray_share(double analyzer_deg);

/// What stray light needs to know of the instrument, by wavelength.
struct StrayGain {
  double wavelength_nm = 0;
  double gain_constant_v = 0;  ///< C
  double phase_rad = 0;
};

struct StrayOptions {
  double tolerance_per_sr = 1e-4;  ///< one sigma of L and F where nothing is measured, and prior
};

/// Fits the records of blocks `no_sample` of all scans. The dark signal of each range enters with
/// its own uncertainty; where it was not measured, power steps (`nd`) tell the two apart, else
/// `notes` say that they cannot be. `solid_angle_sr` belongs to the gain constants.
StrayLight find_stray_light(std::span<const RangeInput> inputs, std::span<const StrayGain> gains,
                            double solid_angle_sr, const RangeErrors& ranges,
                            const StrayOptions& options, std::vector<std::string>& notes);

}  // namespace umov::calibrate
