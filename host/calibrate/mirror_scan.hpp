// The records of a mirror scan, ready for the fit of polariser and analyser.
#pragma once

#include <string>
#include <vector>

#include "host/calibrate/dark.hpp"
#include "host/calibrate/gain_range.hpp"
#include "host/formats/scan_table.hpp"

namespace umov::calibrate {

struct MirrorRow {
  std::size_t wavelength = 0;  ///< number in MirrorRecords::wavelengths_nm
  std::size_t set = 0;         ///< number of the set of equal wavelength, block and filter
  std::size_t scale = 0;       ///< number of the set's angle of incidence: one free scale each
  double theta_i_deg = 0, polarizer_deg = 0, analyzer_deg = 0;
  /// Sense of the element's last move, 1 or -1: play leaves it behind by half of it.
  int polarizer_direction = 1, analyzer_direction = 1;
  double gain = 1;
  double signal_v = 0;     ///< dark-subtracted, in phase, nominal range
  double variance_v2 = 0;  ///< of the signal without what goes with it
  double monitor_v = 0;
};

/// Mean monitor reading of one set behind the polariser at one axis: it weighs the light before the
/// polariser.
struct MirrorMonitor {
  std::size_t wavelength = 0, set = 0;
  double polarizer_deg = 0;
  double log_monitor = 0, u = 0;
};

struct MirrorRecords {
  std::vector<double> wavelengths_nm;
  std::vector<MirrorRow> rows;
  std::vector<MirrorMonitor> monitors;
  std::size_t sets = 0;
  std::vector<std::size_t> set_wavelength;
  struct Scale {
    std::size_t wavelength, set;
    double theta_i_deg;
  };
  std::vector<Scale> scales;
  std::vector<double> gains;  ///< ranges that occur, ascending
  std::vector<std::string> notes;
};

/// Takes the plain, unsaturated records in the mirror direction, incidence 5 deg and up. Throws
/// umov::Error where the scan has another role or has no such record, and where states or angles
/// that the fit needs are missing (it names them).
MirrorRecords mirror_records(const formats::ScanTable& scan, const Dark& dark);

}  // namespace umov::calibrate
