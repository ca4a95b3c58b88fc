// The records of a white standard as rows for its fit: what is known of each is taken out.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "host/calibrate/calibration.hpp"
#include "host/calibrate/standard_fit.hpp"

namespace umov::calibrate {

/// The standard scan with everything derived from it once.
struct PreparedStandard {
  const StandardScan* standard;
  ScanRows set_up;
  NoiseModel noise;
  Dark dark;
  std::vector<LockinPhase> phases;
  RangeErrors ranges;
  Nonlinearity nonlinearity;
  double solid_angle_sr;
  double theta_i_deg = 0;  ///< incidence used where the standard is not tabulated
};

/// The usable records at a wavelength.
std::vector<StandardRow> rows_of(const PreparedStandard& input, double wavelength,
                                 double phase_rad);

/// Variances at the signal to be expected: taken at the measured one, a record that is wrongly dark
/// would get the largest weight of all.
void set_variances(std::vector<StandardRow>& rows, const PreparedStandard& input,
                   double wavelength);

/// Takes stray light out of the rows; the gain constant it needs comes from the rows themselves.
void subtract_stray(std::vector<StandardRow>& rows, const StrayLight& stray, double wavelength);

/// What true elements bring to the detector beyond ideal ones; nothing where `entry` is null.
void apply_polarization(std::vector<StandardRow>& rows, const PolarizationWavelength* entry);

/// WavelengthCalibration::polarization_shift.
Eigen::MatrixXd polarization_shift(const std::vector<StandardRow>& rows, const StandardFit& fit,
                                   const PolarizationWavelength& entry, Eigen::Index parameters);

}  // namespace umov::calibrate
