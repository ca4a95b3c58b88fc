// A calibration as the plain columns of cal.h5: one list for the writer, the reader and the
// checksum.
#pragma once

#include <array>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "host/calibrate/calibration.hpp"
#include "host/formats/h5_header.hpp"

namespace umov::calibrate {

inline constexpr const char* calibration_format_name = "umov cal h5";
inline constexpr const char* ranges_covariance = "/covariance/ranges";
inline constexpr const char* polarization_covariance = "/covariance/polarization";
inline constexpr const char* stray_covariance = "/covariance/stray_light";

struct CalibrationColumn {
  std::vector<double> values;
  std::string unit;
};

struct CalibrationColumns {
  std::map<std::string, CalibrationColumn> numbers;
  std::map<std::string, std::vector<std::string>> texts;

  void number(const std::string& path, double value, const std::string& unit) {
    numbers[path].values.push_back(value);
    numbers[path].unit = unit;
  }
  void text(const std::string& path, const std::string& value) { texts[path].push_back(value); }
  /// A column that may have no entry.
  void declare(const std::string& path, const std::string& unit) { numbers[path].unit = unit; }
  void declare_text(const std::string& path) { texts[path]; }
};

/// Path of a column that every wavelength has its own of.
std::string per_wavelength(const std::string& path, const WavelengthCalibration& entry);

inline constexpr std::array<std::pair<Systematic::Kind, const char*>, 8> systematic_kind_names = {{
    {Systematic::Kind::dark, "dark"},
    {Systematic::Kind::range, "range"},
    {Systematic::Kind::nonlinearity, "nonlinearity"},
    {Systematic::Kind::stray, "stray light"},
    {Systematic::Kind::detector_zero, "detector zero"},
    {Systematic::Kind::detector_eccentricity, "detector eccentricity"},
    {Systematic::Kind::detector_play, "detector play"},
    {Systematic::Kind::standard_lean, "standard lean"},
}};

/// Numbers of a reciprocity result: one list for the writer and the reader.
inline constexpr std::array<std::pair<const char*, double Reciprocity::*>, 10> reciprocity_columns =
    {{
        {"wavelength_nm", &Reciprocity::wavelength_nm},
        {"mean", &Reciprocity::mean},
        {"mean_u", &Reciprocity::mean_u},
        {"mean_absolute", &Reciprocity::mean_absolute},
        {"rms", &Reciprocity::rms},
        {"rms_expected", &Reciprocity::rms_expected},
        {"largest", &Reciprocity::largest},
        {"largest_theta_i_deg", &Reciprocity::largest_theta_i_deg},
        {"largest_theta_r_deg", &Reciprocity::largest_theta_r_deg},
        {"chi2", &Reciprocity::chi2},
    }};

/// Files of version 0.1.0 have these of the declared keys and no others; a file without the others
/// keeps its checksum.
bool always_declared(const DeclaredKey& key);

CalibrationColumns calibration_columns(const Calibration& calibration);

std::string checksum(const CalibrationColumns& columns, const formats::Keys& keys);

}  // namespace umov::calibrate
