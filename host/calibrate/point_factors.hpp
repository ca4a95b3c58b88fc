// The shared uncertainties of reduced points: how each point moves with one standard deviation of
// every calibration quantity.
#pragma once

#include <string>
#include <vector>

#include "host/calibrate/calibration.hpp"
#include "host/formats/brdf_table.hpp"

namespace umov::calibrate {

/// What a point's value depends on.
struct PointOrigin {
  std::size_t record = 0;      ///< of the scan
  std::size_t wavelength = 0;  ///< number in the calibration
  double gain = 1;
  /// Where the arms were commanded and from where the detector came, 1 or -1; the table may have
  /// the true angles.
  double theta_i_commanded_deg = 0, theta_r_commanded_deg = 0;
  int direction = 1;
  double by_incidence_per_sr_deg = 0;  ///< AngleSlopes::incidence
  double by_detector_per_sr_deg = 0;   ///< AngleSlopes::detector
  double aperture_excess_per_sr = 0;   ///< taken out of the point: see aperture.hpp
  double aperture_doubt_per_sr = 0;    ///< one standard deviation of that
  double per_volt = 0;                 ///< d f / d (true volts), 1/(sr V)
  double bias_lever = 0;  ///< the signal goes with 1 + δ lever; divided out where δ is applied
  double open_bias = 0;   ///< unknown lever of an open analyser: one standard deviation of Q/I
  bool own_dark = false;  ///< dark level measured in the scan itself
  double signal_v = 0;    ///< true signal, V of range 1
  double stray_v = 0;     ///< volts of stray light per level, V sr: C a ΔΩ monitor
  bool other_solid_angle = false;  ///< another one than the standard was measured with
  double noise_dof = 0;            ///< degrees of freedom of the noise of this record
};

/// Factors of the points of `table` (in the order of `origin`). Left out are those that nobody
/// could see in these points: Σ (shift/u)² < .003 over all of them. Names: "gain 532 nm",
/// "instrument function 532 nm 1" …, "detector bias 532 nm", "reference standard", "reference
/// shape", "dark range 100", "scan dark range 100", "gain range 100", "detector nonlinearity",
/// "stray light 1" …, and those of declared_causes().
std::vector<formats::BrdfTable::Factor> point_factors(const formats::BrdfTable::Points& points,
                                                      const std::vector<PointOrigin>& origin,
                                                      const Calibration& calibration,
                                                      const Dark& scan_dark);

/// d ln f of points at θr for a shift of the parameters of their wavelength; `bias_lever` as in
/// PointOrigin.
double log_shift(const WavelengthCalibration& entry, double theta_r_deg, double bias_lever,
                 const Eigen::VectorXd& shift);

/// Name of the factor of column `column` of a gain's covariance.
std::string statistics_factor_name(const WavelengthCalibration& entry, Eigen::Index column);

}  // namespace umov::calibrate
