// The scans that a plan makes: the sample's own, and the white tile's that its file refers to.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "host/scan/arrangement.hpp"
#include "host/scan/plan.hpp"

namespace umov::scan {

/// One scan file to measure.
struct ScanPart {
  Plan plan;
  std::filesystem::path output;
  Arrangement standing;  ///< what lies on the stage instead of the plan's sample; plain if it does
};

/// The sample's scan, and for a block `white_tile` a scan of the tile beside it
/// (`scan.h5` → `scan-white.h5`, role white), which the sample's file names in its key `reference`.
/// `only` keeps nothing but the blocks of that name ("main": the plan's own grid); with
/// `white_tile` the tile's scan goes to `output` itself. Throws umov::Error: no such block, two
/// white tiles, or a white tile beside a key `reference`.
std::vector<ScanPart> scan_parts(const Plan& plan, const std::filesystem::path& output,
                                 const std::optional<std::string>& only = std::nullopt);

}  // namespace umov::scan
