// A scan in memory: exactly the columns of the Scan CSV contract, one entry a lock-in record.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace umov::formats {

/// Transmission axis of polariser or analyser in degrees from p towards +s, or NaN for `open` (U).
/// `is_open(angle)` tells.
bool is_open(double axis_deg);
extern const double open_axis;  ///< the NaN that stands for `open`

/// A set-up block `# block: NAME FIRST-LAST key=value …`; rows first..last by index, inclusive.
struct Block {
  std::string name;
  std::int64_t first = 0;
  std::int64_t last = 0;
  std::vector<std::pair<std::string, std::string>> settings;
};

/// Raw lock-in records; all columns have the same length. Angles in degrees, commanded.
struct ScanTable {
  /// Header keys in file order without blocks ("sample", "solid_angle_sr", unknown ones too).
  std::vector<std::pair<std::string, std::string>> keys;
  std::vector<Block> blocks;

  std::vector<std::int64_t> index;
  std::vector<double> time_s;
  std::vector<double> theta_i_deg, theta_r_deg, phi_r_deg, wavelength_nm;
  std::vector<double> polarizer_deg, analyzer_deg;  ///< open_axis = open
  std::vector<int> direction;                       ///< 1 or -1
  std::vector<double> gain;                         ///< nominal amplifier range
  std::vector<double> x_v, y_v, x_se_v, y_se_v;     ///< volts referred to range 1
  std::vector<double> monitor_v;
  std::vector<int> saturated;     ///< 0 or 1
  std::vector<int> shutter_open;  ///< 1 open, 0 closed

  std::size_t size() const { return index.size(); }
  void reserve(std::size_t n);
  /// Value of a header key; nullopt where absent.
  std::optional<std::string> key(const std::string& name) const;
  /// Number of a header key; throws umov::Error where it is not a number.
  std::optional<double> number(const std::string& name) const;
  void set_key(const std::string& name, const std::string& value);
};

}  // namespace umov::formats
