// Reader of the NIST sintered-PTFE Mueller BRDF table (T. A. Germer, Applied Optics 2017).
#pragma once

#include <filesystem>
#include <iosfwd>
#include <string>

#include "host/formats/mueller_table.hpp"

namespace umov::formats {

/// Columns: wavelength in micrometres, thetai, phi, thetar, phir in degrees, f11 in 1/sr, then the
/// other fifteen elements relative to f11. Throws umov::Error with line and column.
MuellerTable read_nist_ptfe(const std::filesystem::path& path);
MuellerTable read_nist_ptfe(std::istream& in, const std::string& name);

}  // namespace umov::formats
