// Files that hold the BRDF of a white standard.
#pragma once

#include <filesystem>

#include "host/formats/brdf_table.hpp"

namespace umov::calibrate {

/// Reads a standard's table by its content: brdf.h5; the NIST PTFE table (Mueller matrices, all
/// states of polariser and analyser are made from it); or CSV with a header line that names at
/// least theta_i_deg, theta_r_deg (signed), wavelength_nm and brdf_per_sr (or `value`), further
/// phi_r_deg, polarizer_deg, analyzer_deg (a number or `open`; absent = open), brdf_u (or
/// `uncertainty`), used, quantity (rows that are not `brdf` are skipped). Lines of `#` are
/// comments. Throws umov::Error with line and column.
formats::BrdfTable read_reference_table(const std::filesystem::path& path);

}  // namespace umov::calibrate
