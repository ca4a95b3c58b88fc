// The columns of a scan, declared once: Scan CSV, scan.h5 and validation are made from this table.
#pragma once

#include <array>
#include <string_view>
#include <variant>
#include <vector>

#include "host/formats/scan_table.hpp"

namespace umov::formats {

/// How a column's numbers are written in canonical text.
enum class Text {
  integer,         ///< plain
  seconds,         ///< %.3f
  angle,           ///< %g
  signal,          ///< %.8g
  standard_error,  ///< %.4g
  monitor,         ///< %.7g
  axis,            ///< %g or `open`
  range,           ///< plain integer where it is one
  shutter          ///< `open` or `closed`
};

using ColumnData = std::variant<std::vector<double> ScanTable::*, std::vector<int> ScanTable::*,
                                std::vector<std::int64_t> ScanTable::*>;

struct ScanColumn {
  std::string_view name;
  std::string_view unit;     ///< as the attribute `unit` of scan.h5
  std::string_view meaning;  ///< one phrase
  Text text;
  double lowest, highest;  ///< permitted values, inclusive
  ColumnData data;
};

inline constexpr double unlimited = 1e300;

inline const std::array<ScanColumn, 17> scan_columns = {{
    {"index", "1", "row of the plan, from 0", Text::integer, 0, 9e15, &ScanTable::index},
    {"time_s", "s", "centre of integration", Text::seconds, -unlimited, unlimited,
     &ScanTable::time_s},
    {"theta_i_deg", "deg", "incidence, commanded", Text::angle, 0, 90, &ScanTable::theta_i_deg},
    {"theta_r_deg", "deg", "detector, commanded, forward > 0 in plane", Text::angle, -90, 90,
     &ScanTable::theta_r_deg},
    {"phi_r_deg", "deg", "azimuth of the detector plane, above -180 up to 180", Text::angle, -180,
     180, &ScanTable::phi_r_deg},
    {"wavelength_nm", "nm", "laser", Text::angle, 100, 1e5, &ScanTable::wavelength_nm},
    {"polarizer_deg", "deg", "transmission axis from p towards +s, or open", Text::axis, -360, 360,
     &ScanTable::polarizer_deg},
    {"analyzer_deg", "deg", "transmission axis from p towards +s, or open", Text::axis, -360, 360,
     &ScanTable::analyzer_deg},
    {"direction", "1", "sense of the last detector-arm move, 1 or -1", Text::integer, -1, 1,
     &ScanTable::direction},
    {"gain", "1", "nominal amplifier range", Text::range, 1e-300, unlimited, &ScanTable::gain},
    {"x_v", "V", "in-phase output referred to range 1", Text::signal, -unlimited, unlimited,
     &ScanTable::x_v},
    {"y_v", "V", "quadrature output referred to range 1", Text::signal, -unlimited, unlimited,
     &ScanTable::y_v},
    {"x_se_v", "V", "standard error of x_v from block scatter", Text::standard_error, 0, unlimited,
     &ScanTable::x_se_v},
    {"y_se_v", "V", "standard error of y_v from block scatter", Text::standard_error, 0, unlimited,
     &ScanTable::y_se_v},
    {"monitor_v", "V", "monitor photodiode", Text::monitor, -unlimited, unlimited,
     &ScanTable::monitor_v},
    {"saturated", "1", "1 if any ADC sample clipped", Text::integer, 0, 1, &ScanTable::saturated},
    {"shutter", "1", "open or closed", Text::shutter, 0, 1, &ScanTable::shutter_open},
}};

}  // namespace umov::formats
