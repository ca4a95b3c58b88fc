// The signal that is there without light, per amplifier range, and the lock-in's phase.
#pragma once

#include <cstddef>
#include <vector>

#include "host/calibrate/noise.hpp"
#include "host/calibrate/set_up.hpp"
#include "host/formats/scan_table.hpp"

namespace umov::calibrate {

/// Dark signal of one amplifier range, volts referred to range 1.
struct DarkLevel {
  double gain = 1;
  double x_v = 0, x_u = 0;
  double y_v = 0, y_u = 0;
  std::size_t records = 0;  ///< shutter-closed records behind it; 0 = assumed zero
};

struct Dark {
  std::vector<DarkLevel> levels;  ///< ascending range
  /// The level of a range; ranges that were not measured get zero with the largest uncertainty
  /// known.
  DarkLevel at(double gain) const;
  bool measured(double gain) const;
};

/// Weighted means of the shutter-closed records of each range; the scatter between records widens
/// the uncertainty where it exceeds the noise law. Ranges that occur in the scan without a closed
/// record get zero; their uncertainty is the size of the quadrature signal of that range that does
/// not go with X (an offset of the electronics shows there too, a lock-in phase does not) or its
/// standard error, whichever is larger.
Dark find_dark(const formats::ScanTable& scan, const ScanRows& set_up, const NoiseModel& noise);

/// Dark of a scan of role `dark`: all of its rows count as closed.
Dark find_dark_of_dark_scan(const formats::ScanTable& scan, const NoiseModel& noise);

/// `first` where it has measured levels, completed by measured levels of `second`.
Dark merge(const Dark& first, const Dark& second);

/// Measured levels of several scans of one instrument, range by range: weighted means, widened
/// where the scans differ by more than their uncertainties.
Dark pool(const std::vector<Dark>& scans);

/// Lock-in phase: X + iY = S exp(i phase).
struct LockinPhase {
  double wavelength_nm = 0;
  double phase_rad = 0, u_rad = 0;
};

/// Weighted angle of the strong signals, one entry a wavelength.
std::vector<LockinPhase> find_phase(const formats::ScanTable& scan, const ScanRows& set_up,
                                    const NoiseModel& noise, const Dark& dark);

}  // namespace umov::calibrate
