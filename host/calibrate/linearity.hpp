// The detector's law and the amplifier ranges together, from the same light seen at several powers.
//
// A record of true signal S (V, range 1) behind a detector of nonlinearity κ and an amplifier range
// of relative error e reads S (1 + e)/(1 + κS). Neutral density changes the power by what the
// monitor says, an automatic amplifier changes the range with it, so that κ and e belong into one
// fit.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "host/calibrate/dark.hpp"
#include "host/calibrate/gain_range.hpp"

namespace umov::calibrate {

/// The detector's law: a signal S reads S/(1 + κS). One for all wavelengths.
struct Nonlinearity {
  double kappa_per_v = 0, kappa_u_per_v = 0;
  bool measured = false;        ///< false: `kappa_u_per_v` is what was assumed
  double strongest_v = 0;       ///< largest signal that was compared
  std::size_t records = 0;      ///< that were compared
  double dof = 0;               ///< degrees of freedom of the comparison
  Eigen::VectorXd with_ranges;  ///< covariance with the errors of the amplifier ranges

  /// True signal of a recorded one, both in V with the range's error taken out.
  double true_signal(double recorded_v) const {
    return recorded_v / (1.0 - kappa_per_v * recorded_v);
  }
};

/// Errors of the ranges and, last, κ: column k of the lower Cholesky factor of their joint
/// covariance, that is, all errors for one standard deviation of the k-th independent cause. Side:
/// number of ranges + 1.
Eigen::MatrixXd electronics_shifts(const RangeErrors& ranges, const Nonlinearity& nonlinearity);

struct LinearityOptions {
  double range_tolerance = 1e-3;        ///< as in find_range_errors
  double kappa_tolerance_per_v = 1e-3;  ///< one sigma of κ where nothing is measured
  /// Relative, one sigma: what the monitor misses from one run of records (block, wavelength,
  /// filter, incidence) to the next.
  double drift = 0.003;
};

struct Linearity {
  RangeErrors ranges;
  Nonlinearity nonlinearity;
  /// Relative scatter of one record (what the monitor misses), found from the residuals.
  double slow_noise = 0;
  double chi2 = 0;  ///< with the slow noise in
  std::vector<std::string> notes;
};

/// Compares records of equal geometry, states and wavelength of each scan that differ in power or
/// range. The tolerance of κ is its prior. `notes` say where the comparisons tell less than it,
/// where they contradict it, and where κ and a range cannot be told apart.
Linearity find_linearity(std::span<const RangeInput> inputs, const LinearityOptions& options = {});

/// Runs of records that drift may set apart, as find_linearity sees them: number of the run of each
/// record, ascending from 0.
std::vector<std::size_t> runs_of(const formats::ScanTable& scan, const ScanRows& set_up);

}  // namespace umov::calibrate
