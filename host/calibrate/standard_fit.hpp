// Weighted fit of gain, instrument function and detector bias to a standard's records at one
// wavelength.
#pragma once

#include <vector>

#include <Eigen/Core>

namespace umov::calibrate {

/// One record of the standard, ready for the fit.
struct StandardRow {
  double signal_v = 0;  ///< dark-subtracted, rotated in phase, range error taken out
  double variance = 1;  ///< V², monitor included
  double base = 0;      ///< f cosθr ΔΩ monitor of the standard: the signal is C base /IF …
  double theta_r_deg = 0;
  double phi_r_deg = 0;
  double stray_base = 0;         ///< a ΔΩ monitor: stray light of level L brings C L times this
  double volts_per_stray = 0;    ///< C times that, once C is known
  double from_retro_deg = 90;    ///< angle between exit direction and the way back to the source
  int direction = 1;             ///< of the detector's last move
  double log_slope_per_deg = 0;  ///< d ln(f cosθr)/dθr of the standard
  double gain = 1;
  double bias_lever = 0;       ///< the signal goes with 1 + δ lever
  double retention_lever = 0;  ///< and with 1 + m lever, m the polarisation that the standard keeps
  double polarizer_deg = 0, analyzer_deg = 0;
};

struct StandardModel {
  std::vector<int> degrees;  ///< of the instrument function
  double reference_deg = 0;
  bool bias = false;
  double retention_u = 0;  ///< prior of m, one sigma; 0 = m is not fitted
  /// What is known of δ beforehand; bias_prior_u 0 = nothing.
  double bias_prior = 0, bias_prior_u = 0;
  /// Prior of the standard's own polarisation, which looks like δ; 0 = it is not fitted. Used
  /// beside a prior of δ, which tells the two apart.
  double polarization_u = 0;

  /// Parameters beyond ln C and the instrument function.
  int levers() const {
    return (bias ? 1 : 0) + (retention_u > 0 ? 1 : 0) + (polarization_u > 0 ? 1 : 0);
  }
};

/// Parameters: ln C, instrument-function coefficients, δ, m, the standard's own polarisation (each
/// if fitted).
struct StandardFit {
  StandardModel model;
  Eigen::VectorXd parameters;
  Eigen::MatrixXd covariance;  ///< widened by chi2/dof where that exceeds one
  Eigen::MatrixXd response;    ///< d parameters / d signal of each row, 1/V
  std::vector<double> pull;    ///< residual over its standard deviation, a row
  double chi2 = 0, dof = 0;
};

/// Takes out rows whose signal is less than half or more than twice that of their neighbours (a
/// detector in the beam's way, a reflection): no instrument function does that, and no least
/// squares survives it. Returns the angle about the retro direction within which records were dark,
/// up to the nearest good one; 0 where none was.
double remove_gross(std::vector<StandardRow>& rows);

/// Gauss–Newton from a robust start; the model is log-linear but for δ and m. Throws umov::Error
/// where the rows cannot determine the parameters.
StandardFit fit_standard(const std::vector<StandardRow>& rows, const StandardModel& model);

/// The instrument function by evidence: all polynomials up to `max_degree`, full and even ones
/// (even ones only where `two_sided` is false), averaged with their posterior probabilities by BIC;
/// a constant one has prior probability 1/2. Picking the best single order instead would hide that
/// the data cannot quite tell (measured: gains off by more than stated in one case of ten). The
/// covariance holds the spread between orders. Residual scatter beyond the noise, of the richest
/// model, counts as noise.
StandardFit choose_instrument_function(const std::vector<StandardRow>& rows, StandardModel model,
                                       int max_degree, bool two_sided);

}  // namespace umov::calibrate
