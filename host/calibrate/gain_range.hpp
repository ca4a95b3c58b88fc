// True ratio of the amplifier ranges to their nominal values, from signals measured in two ranges.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "host/calibrate/dark.hpp"

namespace umov::calibrate {

/// A range's relative error: recorded volts = true volts (1 + error). The lowest range is exact.
struct RangeError {
  double gain = 1;
  double error = 0, u = 0;
  bool measured = false;  ///< false: nominal, `u` is the tolerance assumed
};

struct RangeErrors {
  std::vector<RangeError> ranges;  ///< ascending range
  double tolerance = 1e-3;         ///< relative, one sigma, of a range that was not measured
  /// Of the errors, in the order of `ranges`: a chain of comparisons couples all ranges above.
  Eigen::MatrixXd covariance;
  RangeError at(double gain) const;
  /// Place in `ranges`; -1 where the range is not among them.
  Eigen::Index number(double gain) const;
  /// Lower Cholesky factor of the covariance: column k holds the errors of all ranges for one
  /// standard deviation of the k-th independent cause. Rows and columns of exact ranges are zero.
  Eigen::MatrixXd shifts() const;
};

/// One scan with what is needed to compare its records.
struct RangeInput {
  const formats::ScanTable* scan;
  const ScanRows* set_up;
  const NoiseModel* noise;
  const Dark* dark;
};

/// Compares records of equal geometry, states and wavelength that were taken in different ranges.
/// Ranges without overlap keep error 0 and the uncertainty `tolerance` (relative, one sigma).
RangeErrors find_range_errors(std::span<const RangeInput> inputs, double tolerance = 1e-3);

}  // namespace umov::calibrate
