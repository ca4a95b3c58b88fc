// A white standard's scan from its file, with what the file says is known of the standard.
#pragma once

#include <filesystem>
#include <optional>

#include "host/calibrate/calibration.hpp"

namespace umov::calibrate {

/// Reads scan.h5 or Scan CSV. The standard's BRDF comes from `reference_table` where given, else
/// from the file that the key `reference_brdf` names (absolute, or beside the scan), else from the
/// keys `reference_dhr_<nm>`. Named after the key `sample`, or the file. Throws umov::Error where
/// the role is another than `white`.
StandardScan read_standard(const std::filesystem::path& path,
                           const std::optional<std::filesystem::path>& reference_table = {});

/// The same for a scan that is in memory already.
StandardScan make_standard(formats::ScanTable scan, const std::filesystem::path& path,
                           const std::optional<std::filesystem::path>& reference_table = {});

}  // namespace umov::calibrate
