// The noise of a lock-in record as a smooth function of signal and amplifier range.
//
// A record's own standard error comes from a few blocks (some ten degrees of freedom), so it is
// itself uncertain by a quarter and happens to be small where the blocks happen to agree: weights
// made of it are noisy and biased. All records of a wavelength together fix
//   variance(S, g) = base² + (adc/g)² + b S + (r S)²        [V², referred to range 1]
// S the size of the signal, g the amplifier range: noise before the range switch, noise of the
// digitiser behind it, photon noise, and fluctuation of the source.
#pragma once

#include <cstddef>
#include <limits>
#include <vector>

#include "host/formats/scan_table.hpp"

namespace umov::calibrate {

/// Variance law of one lock-in channel at one wavelength. All coefficients >= 0.
struct NoiseLaw {
  double base_v2 = 0;        ///< V²
  double adc_v2 = 0;         ///< V², at range 1; divided by the square of the range
  double shot_v = 0;         ///< b, V
  double relative2 = 0;      ///< r², 1
  double dof = 9;            ///< degrees of freedom of a record's block scatter, estimated
  std::size_t rows = 0;      ///< records used
  std::size_t outliers = 0;  ///< records whose scatter is far outside the law; not used

  /// Variance in V² of a record with signal `signal_v` (either sign) at amplifier range `gain`.
  double variance(double signal_v, double gain) const;
};

struct NoiseOptions {
  /// Volts of one ADC code at range 1; NaN = from the key `adc_step_v`, 0 where absent.
  double adc_step_v = std::numeric_limits<double>::quiet_NaN();
};

/// Noise of a scan, per wavelength. Wavelengths are matched within 0.5 nm.
class NoiseModel {
 public:
  struct Entry {
    double wavelength_nm = 0;
    NoiseLaw x, y;
    /// Relative scatter of the monitor from one record to the next: its own noise and the source's.
    double monitor_relative = 0;
    /// Relative variance coefficient (1) of x/monitor between repeats of the same geometry;
    /// NaN where the scan has fewer than ten degrees of freedom of repeats.
    double repeat_relative2 = std::numeric_limits<double>::quiet_NaN();
    std::size_t repeat_dof = 0;
  };
  std::vector<Entry> entries;
  /// Step of the recorded voltages at range 1 where they lie on a lattice of ADC codes, else 0 (the
  /// lock-in averages many samples, and its block scatter has seen the rounding).
  double quantisation_v = 0;

  /// Throws umov::Error for a wavelength that the scan has not.
  const Entry& at(double wavelength_nm) const;
  /// False where all records of the wavelength are saturated.
  bool has(double wavelength_nm) const;
  /// Variance of x_v, V², quantisation included.
  double variance_x(double wavelength_nm, double gain, double signal_v) const;
  /// Variance of y_v for a record with in-phase signal `signal_v`.
  double variance_y(double wavelength_nm, double gain, double signal_v) const;
  /// Variance of x_v after division by the monitor, expressed at the signal, V². The relative term
  /// is the one seen between repeats where there are enough; else the larger of the block scatter's
  /// and the monitor's (source noise that the monitor cancels cannot be told apart without
  /// repeats).
  double variance_normalised(double wavelength_nm, double gain, double signal_v) const;
  /// The relative term of that variance alone, 1.
  double relative2_normalised(double wavelength_nm) const;
  /// That variance without its relative term, V².
  double variance_floor(double wavelength_nm, double gain, double signal_v) const;
  /// Degrees of freedom of that variance: the block scatter of all records of the wavelength for
  /// its floor, the repeats for the relative part where they fixed it (Welch–Satterthwaite).
  double dof_normalised(double wavelength_nm, double gain, double signal_v) const;
};

/// Fits the law of each wavelength to the block scatter of all unsaturated records, shutter-closed
/// ones included, by the gamma likelihood that squared standard errors follow; terms that the data
/// do not ask for (corrected Akaike criterion) stay zero. Any number of rows from one up. Throws
/// umov::Error where no unsaturated record is left.
NoiseModel fit_noise(const formats::ScanTable& scan, const NoiseOptions& options = {});

/// The law that fits variances `v2` (V²) seen at signals and ranges; used by fit_noise.
NoiseLaw fit_law(const std::vector<double>& v2, const std::vector<double>& signal_v,
                 const std::vector<double>& gain);

}  // namespace umov::calibrate
