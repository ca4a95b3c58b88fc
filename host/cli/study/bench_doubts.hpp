// What an operator knows of a bench's reproducibility beyond the calibration, put to the points of
// a scan before they are fitted.
#pragma once

#include "host/formats/brdf_table.hpp"

namespace umov::study {

/// One standard deviation each.
struct BenchDoubts {
  /// Relative: slow noise of the lasers that the monitor misses. From the standard's scan to this
  /// one it is common to a wavelength, and again to all points of a wavelength and an incidence,
  /// which are measured within minutes.
  double source = 0.003;
  /// Where a drive stops, degrees, from point to point: periodic errors of gear and encoder. The
  /// detector's and the incidence arm's count alike, as a lobe sees their difference.
  double position_deg = 0.012;
};

/// The table with factors "source NM" and "source NM, θi DEG", and with the position's part in
/// `brdf_u`, by the slope of the BRDF along θr.
formats::BrdfTable with_bench_doubts(formats::BrdfTable table, const BenchDoubts& doubts = {});

}  // namespace umov::study
