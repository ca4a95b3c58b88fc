// What a calibration knows of the instrument, with covariance: gain per wavelength, instrument
// function, lock-in phase, dark signal, amplifier ranges, detector law, stray light.
//
// Signal of a record: X cos φ + Y sin φ = dark + (1 + e_g) S/(1 + κS) with
//   S = C [f cosθr D / IF(θr) + a L(θr)] ΔΩ monitor,
// f the BRDF seen by polariser and analyser, D = 1 - δ cos 2α behind an analyser at α, 1 + δ Q/I
// without one, L the stray light and a = 1/2 behind an analyser, else 1.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "host/calibrate/dark.hpp"
#include "host/calibrate/declared_doubts.hpp"
#include "host/calibrate/gain_range.hpp"
#include "host/calibrate/instrument_function.hpp"
#include "host/calibrate/linearity.hpp"
#include "host/calibrate/polarization.hpp"
#include "host/calibrate/reciprocity.hpp"
#include "host/calibrate/reference_standard.hpp"
#include "host/calibrate/stray_light.hpp"

namespace umov::calibrate {

/// Calibration at one wavelength. Parameters in the order ln C, coefficients of the instrument
/// function, δ (only where `bias_active`).
struct WavelengthCalibration {
  double wavelength_nm = 0;
  double gain_constant_v = 0;  ///< C
  InstrumentFunction instrument_function;
  double detector_bias = 0;  ///< δ: response to Stokes (1, δ, 0, 0), + favours s
  /// Where δ is not applied, points carry this as a doubt; 0 = the user asserts that there is none.
  double detector_bias_u = 0;
  bool bias_active = false;  ///< δ is applied
  /// d ln C / dδ of a gain that was fitted without δ: the mean lever of the standard's records.
  /// What is measured with the same lever does not notice δ.
  double gain_bias_lever = 0;
  Eigen::MatrixXd covariance;  ///< of the parameters, from the noise of the standard's scan
  /// d parameters / d PolarizationParameter (columns), as the standard was measured with the same
  /// polariser, analyser and monitor; the column of δ is zero, as δ is a parameter itself. Empty
  /// where there is no polarisation calibration.
  Eigen::MatrixXd polarization_shift;
  double phase_rad = 0, phase_u_rad = 0;
  double reference_relative_u = 0;  ///< scale of the standard, shared by all wavelengths
  std::size_t records = 0, rejected = 0;
  /// Relative scatter of a record as the standard's records show it, where that is more than the
  /// noise law of the scan; 0 = it is not.
  double record_scatter = 0;
  /// Relative scatter of the standard's records about its fit beyond their noise, what the model of
  /// the standard misses included; `covariance` contains it.
  double standard_scatter = 0;
  double chi2 = 0;
  double dof = 0;

  Eigen::Index parameters() const {
    return 1 + static_cast<Eigen::Index>(instrument_function.degrees.size()) +
           (bias_active ? 1 : 0);
  }
};

/// A calibration quantity that points share beyond the gain's own statistics: shift of each
/// wavelength's parameters for one standard deviation; of ranges and nonlinearity, for the column
/// of electronics_shifts() that belongs to `gain` (nonlinearity: the last one); of stray light, for
/// column `cause` of StrayLight::shifts(). Of the declared angles, those at which the standard was
/// measured: zero, eccentricity (cause 0: its cosine, 1: its sine) and play of the detector arm,
/// and how the standard leant on its plate.
struct Systematic {
  enum class Kind {
    dark,
    range,
    nonlinearity,
    stray,
    detector_zero,
    detector_eccentricity,
    detector_play,
    standard_lean
  };
  Kind kind;
  double gain = 1;  ///< amplifier range concerned; 0 = none
  std::size_t cause = 0;
  std::vector<Eigen::VectorXd> shift = {};  ///< per wavelength, in the order of its parameters
};

/// By how much the detector stands beside θr for one standard deviation of an angle error;
/// `direction` 1 or -1 of its last move. Zero for what is no error of an angle.
double detector_shift_deg(const Systematic& systematic, const DeclaredDoubts& declared,
                          double theta_r_deg, int direction);

/// The angle errors among the systematic quantities that a bench with these doubts has.
std::vector<Systematic> angle_systematics(const DeclaredDoubts& declared);

/// Reflectance of a standard: stated, and computed from its scan with this calibration.
struct StandardCheck {
  std::string standard;
  double wavelength_nm = 0;
  double stated = 0;  ///< NaN where unknown
  double computed = 0, computed_u = 0;
  bool used_for_gain = false;
};

struct CalibrationInput {
  std::string name, role, sha256;
};

struct Calibration {
  double solid_angle_sr = 1e-4;  ///< ΔΩ that C belongs to
  /// Exit directions nearer than this to the way back to the source may be in the detector's own
  /// shadow: the standard was dark there. 0 = none seen.
  double retro_shadow_deg = 0;
  double shape_amplitude = 0;  ///< of the standard, see ReferenceStandard::shape
  double shape_u = 0;          ///< amplitude of ReferenceStandard::shape, one sigma
  std::vector<WavelengthCalibration> wavelengths;
  Dark dark;
  RangeErrors ranges;
  Nonlinearity nonlinearity;
  StrayLight stray;
  DeclaredDoubts declared;
  std::vector<Systematic> systematics;
  std::optional<PolarizationCalibration> polarization;  ///< from a mirror scan
  std::vector<StandardCheck> checks;
  std::vector<Reciprocity> reciprocity;  ///< of a scan reduced with it: all, then by wavelength
  std::vector<CalibrationInput> inputs;
  std::vector<std::string> notes;
  std::vector<std::pair<std::string, std::string>> keys;  ///< device, standard, …

  /// Entry within 0.5 nm; throws umov::Error with the wavelengths known.
  const WavelengthCalibration& at(double wavelength_nm) const;
  std::size_t index_of(double wavelength_nm) const;
};

/// A scan of a white standard with what is known of it.
struct StandardScan {
  formats::ScanTable scan;
  ReferenceStandard reference;
  std::string name, sha256;
};

struct CalibrateOptions {
  std::size_t standard = 0;  ///< number of the standard that fixes gain and instrument function
  int max_degree = 8;        ///< of the instrument function; 0 = IF is one
  double reference_angle_deg = 0;
  enum class Bias { automatic, on, off } bias = Bias::automatic;  ///< automatic: where |δ| > 3 u
  double range_tolerance = 1e-3;
  /// Ranges and detector law where they are known from elsewhere (find_linearity over a campaign);
  /// else the ranges come from the standard's own scan and κ is zero.
  std::optional<Linearity> linearity;
  StrayLight stray;  ///< empty: none
  /// From find_polarization. Its δ joins the standard's own, which is applied then unless `bias` is
  /// off.
  std::optional<PolarizationCalibration> polarization;
  DeclaredDoubts declared;  ///< carried on to the points
  /// Shutter-closed records of other scans of the same instrument complete the standard's.
  Dark dark;
  /// Whether δ is applied, by wavelength, where that was decided before; empty: `bias` says.
  std::vector<bool> bias_decided;
  bool checks = true;  ///< compute the reflectance of the standards
};

/// Variance of a record's signal after division by the monitor, V²: the noise law of its scan, or
/// the scatter of the standard's records where that is more.
double record_variance(const NoiseModel& noise, const WavelengthCalibration& entry, double gain,
                       double signal_v);

/// Calibrates from white standards (one at least) and, optionally, scans with the beam closed.
/// Throws umov::Error where a scan has no usable record, lacks keys, or differs in wavelengths.
Calibration calibrate(std::span<const StandardScan> standards,
                      std::span<const formats::ScanTable> dark_scans = {},
                      const CalibrateOptions& options = {});

/// Reflectance of standards reduced with a calibration; `used` is the number of the one that fixed
/// the gain.
std::vector<StandardCheck> check_standards(std::span<const StandardScan> standards,
                                           std::size_t used, const Calibration& calibration);

/// Calibration from the header keys `gain_constant_<nm>`, `solid_angle_sr` and
/// `gain_constant_relative_u` (default .01) of a scan; IF is one. Throws umov::Error where a key is
/// missing.
Calibration calibration_from_header(const formats::ScanTable& scan);

/// Distinct wavelengths of a scan, ascending.
std::vector<double> wavelengths_of(const formats::ScanTable& scan);

}  // namespace umov::calibrate
