// What a lock-in record was taken with, in radians and plain numbers, ready for the signal chain.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "host/formats/scan_table.hpp"

namespace umov::calibrate {
struct Calibration;
}

namespace umov::gap::scan {

struct Record {
  double theta_i, theta_r, phi_r;  ///< commanded, radians
  std::size_t wavelength;          ///< number in ScanRecords::wavelengths_nm
  bool polarizer_open, analyzer_open;
  double polarizer, analyzer;  ///< transmission axes from p towards s, radians
  int direction;               ///< of the last detector move, 1 or -1
  double gain;                 ///< nominal amplifier range
  double monitor_v;
  double time;  ///< from 0 at the scan's first record to 1 at its last
  double time_s;
  bool shutter_open;
  bool saturated;
  bool sample_flipped;  ///< turned by 180 deg about its normal
  bool sample_removed;
  bool long_pass;        ///< a filter keeps the laser's own light from the detector
  double iris_fraction;  ///< diameter of the detector's aperture over its usual one
  double x_v, y_v;
  int row;  ///< line of detector angles it belongs to
};

/// Which spot is seen in which light and through what: records with the same numbers see the same
/// speckle, whenever they were taken.
std::array<long long, 8> place_of(const Record& record);

/// As many as the chain carries at a time.
inline constexpr std::size_t most_wavelengths = 8;

struct ScanRecords {
  std::vector<Record> records;
  std::vector<double> wavelengths_nm;  ///< ascending
  std::vector<double> gain_constant_v;
  std::vector<double> gain_constant_relative_u;  ///< by wavelength
  double solid_angle_sr = 1e-4;
  double adc_full_scale_v = 0;     ///< 0 = unknown
  std::vector<std::string> notes;  ///< records that cannot be used, and why
};

/// Joins scans of one sample (a prescribed further scan goes behind the first). Rows taken with
/// something that the chain does not know (another sample) are left out with a note. Throws
/// umov::Error where keys are missing or scans contradict each other. With a calibration, the keys
/// of the gain constants may be missing, and the records are corrected by what it knows.
ScanRecords prepare_records(const std::vector<formats::ScanTable>& scans,
                            const calibrate::Calibration* calibration = nullptr);

/// Keeps at most about `most` records, evenly along every row (0: all), with a note. Places that
/// were measured again are kept or left out with all their records, those of three and more are
/// kept.
void thin(ScanRecords& records, std::size_t most);

}  // namespace umov::gap::scan
