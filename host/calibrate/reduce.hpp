// From raw lock-in records to the polarised BRDF, DOLP and DHR with uncertainties.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "host/calibrate/alignment.hpp"
#include "host/calibrate/angle_slopes.hpp"
#include "host/calibrate/calibration.hpp"
#include "host/calibrate/mueller.hpp"
#include "host/calibrate/point_factors.hpp"
#include "host/formats/brdf_table.hpp"
#include "host/formats/scan_table.hpp"

namespace umov::calibrate {

struct ReduceOptions {
  /// Exit angles beyond what the standard covered are flagged; true = used with IF held at its
  /// edge.
  bool extrapolate_instrument_function = false;
  /// |θi| up to this counts as normal incidence for the DHR.
  double normal_incidence_within_deg = 1.0;
  bool dolp = true, dhr = true;
  /// Mueller elements where there are oblique states (±45°); also the four that P and S give where
  /// `mueller_partial`.
  bool mueller = true, mueller_partial = false;
  /// Angles of points in the plane of incidence become the true ones. The declared doubts of zeros
  /// and leans enter a fit by derivatives alone, which is too little for a lobe that is shifted by
  /// a tenth of a degree: this leaves to them what is left.
  Alignment alignment;
  /// The BRDF's course between the points, where it is known better than the points themselves tell
  /// it: for derivatives by the angles and for the average over the detector disc. Empty: from the
  /// points.
  BrdfShape shape;
};

struct ReduceSummary {
  std::size_t records = 0, points = 0, excluded = 0;
  std::size_t saturated = 0, outside_instrument_function = 0, below_noise = 0, in_shadow = 0;
  std::size_t dolp = 0, dolp_skipped = 0;
  double largest_aperture_share = 0;  ///< of the detector disc's excess in a used point's BRDF
  MuellerSummary mueller;
  double median_relative_u = 0;        ///< of used points, independent part
  double median_relative_total_u = 0;  ///< with the shared factors
  std::vector<std::string> notes;
};

struct Reduction {
  formats::BrdfTable table;
  std::vector<PointOrigin> origin;  ///< of each point
  ReduceSummary summary;
};

/// f = (S - C a L ΔΩ monitor) IF(θr) / (C ΔΩ monitor cosθr D), S the true signal behind (X cosφ + Y
/// sinφ - dark)/(1 + e_g) = S/(1 + κS), for every row of the plain set-up. `used` is 0 where the
/// record is saturated, where IF is not known, where the detector may stand in the beam
/// (Calibration::retro_shadow_deg). Points below their noise, of either sign, are counted but used:
/// a choice by value would bias weak signals upwards. `brdf_u` is the independent part (noise law
/// of the scan, monitor included); all that the calibration couples stands in `factors`. Throws
/// umov::Error where the wavelengths do not match.
Reduction reduce(const formats::ScanTable& scan, const Calibration& calibration,
                 const ReduceOptions& options = {});

}  // namespace umov::calibrate
