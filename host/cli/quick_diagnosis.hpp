// What `--quick` means to a diagnosis, wherever it can be asked for.
#pragma once

#include "host/gap/chamber/diagnose_map.hpp"
#include "host/gap/scan/diagnose_scan.hpp"

namespace umov::cli {

/// A quick answer: a quarter of the draws, a small beam, few refits, thinned records.
void make_quick(gap::scan::ScanDiagnoseOptions& options);
/// The same of a map: half as many, larger pixels and an eighth of the rays.
void make_quick(gap::MapDiagnoseOptions& options);

}  // namespace umov::cli
