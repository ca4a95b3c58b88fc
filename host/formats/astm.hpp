// Measured points as ASTM E1392 / E2387 text: header lines `KEY value`, a line VARS that names the
// columns, one point a line. Which keys settle what the standards leave to the laboratory:
// docs/formats/astm.md.
#pragma once

#include <string>
#include <string_view>

#include "host/formats/brdf_table.hpp"
#include "host/formats/table_file.hpp"

namespace umov::formats {

bool is_astm(std::string_view bytes);

/// All blocks of a file as points. Without a column or key of uncertainty each point gets 5 %, and
/// the header of the table says so. Throws umov::Error with line and column for angles out of
/// range, numbers that are none, fewer or more points than NUM_POINTS, colour channels without
/// wavelengths, and angles whose unit neither a key nor their size tells.
BrdfTable read_astm(std::string_view bytes, const std::string& file);

/// Every point with angles in degrees, BRDF in 1/sr, its independent uncertainty and both
/// polarisations. What calibration couples, DOLP and DHR are left out; the header says so.
std::string write_astm(const BrdfTable& table, const TableWriting& writing);

}  // namespace umov::formats
