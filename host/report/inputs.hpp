// Files to samples: which kind a file is, and what belongs together.
#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "host/report/sample.hpp"

namespace umov::report {

using Input = std::variant<BrdfInput, FitInput, ScanInput, CalibrationInput>;

/// Reads a brdf.h5, scan.h5, Scan CSV, cal.h5 or fit.json; which one it is, is found by content.
/// Throws umov::Error for a file that is missing, damaged or of another kind.
Input read_input(const std::filesystem::path& path);

/// Puts together what belongs together, in the order of the measurements given:
/// a fit goes to the measurement whose digest it names (`data_sha256`, of the table or of the
/// file), else to the one whose file name it names, else to the last measurement before it, with a
/// warning; a second fit of the same measurement makes a section of its own. A scan or calibration
/// goes to every measurement that names its digest or file among its keys, else a scan goes to one
/// with the same `sample`, else a calibration to the only measurement there is; what is left gets
/// its own section.
std::vector<Sample> group(std::vector<Input> inputs);

}  // namespace umov::report
