// A scan plan as rows for the bench of a withheld-effect case.
#pragma once

#include <vector>

#include "hil/blind/scan_rows.hpp"
#include "host/scan/plan.hpp"

namespace umov::cli {

/// The plan's own rows and blocks in their order; a plan of a white tile (role white) puts the tile
/// on the stage. Throws umov::Error for lasers or densities that the bench does not have.
std::vector<blind::RowBlock> bench_blocks(const scan::Plan& plan);

}  // namespace umov::cli
