// The uncertainty of reduced points by drawing (GUM Supplement 1), to check what the budget says.
//
// Each draw makes new records of all scans of a campaign and of the scan that is reduced, and runs
// the whole chain on them again. What is drawn:
// - noise of every record by the law of its scan (the standard's widened where its fit was);
// - what calibration assumes without measuring it, from its tolerance, put into the records: errors
//   of the amplifier ranges, nonlinearity, stray light, unmeasured dark signals, drift between runs
//   (for the linearity comparison), scale, shape and polarisation of the standard, the detector's
//   polarisation bias where it is not applied, and the declared doubts of the angles;
// - the polarisation calibration as a whole, from its covariance.
// What the propagation holds as a plain doubt of the points ("undetermined …", "detector bias of
// open analyser") is added with a common sign, as there is nothing behind it that could be drawn.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "host/calibrate/campaign.hpp"
#include "host/calibrate/reduce.hpp"

namespace umov::calibrate {

struct MonteCarloOptions {
  std::size_t draws = 400;
  std::uint64_t seed = 1;  ///< results depend on it alone, not on the number of threads
  int threads = 0;         ///< 0 = all cores
  /// Called from one thread at a time; false = stop, which throws umov::Error.
  std::function<bool(std::size_t done, std::size_t total)> progress;
};

struct MonteCarlo {
  std::size_t draws = 0, failed = 0;  ///< failed: the chain refused the drawn records
  std::vector<double> u_per_sr;       ///< standard deviation of each point
  std::vector<double> shift_per_sr;   ///< mean of the draws minus the point's value
  std::vector<double> dhr_u;          ///< of each DHR of the table
};

/// Draws about `base` and `reduction`, which belong to `scans`, `options` and `scan`. Throws
/// umov::Error where more than a tenth of the draws fail.
MonteCarlo monte_carlo(const std::vector<CampaignScan>& scans, const CampaignOptions& options,
                       const Campaign& base, const CampaignScan& scan, const Reduction& reduction,
                       const ReduceOptions& reduce_options, const MonteCarloOptions& draws);

/// Do draws and propagation agree? The standard deviation of N draws scatters by 1/√(2(N-1));
/// beyond that a twentieth is allowed, as for two significant digits.
struct MonteCarloAgreement {
  std::size_t points = 0;
  double mean_ratio = 0;  ///< geometric mean of u(draws)/u(budget) over used points
  double smallest_ratio = 0, largest_ratio = 0;
  double allowed_mean = 0;    ///< of |ln mean_ratio|
  double allowed_single = 0;  ///< of |ln ratio| of any point
  std::size_t outside = 0;    ///< points beyond
  bool agrees = false;
};

/// `u_per_sr` of the propagation, a point each.
MonteCarloAgreement compare_with_draws(const MonteCarlo& draws, const std::vector<double>& u_per_sr,
                                       const std::vector<int>& used);

}  // namespace umov::calibrate
