// What `--quick` means to a diagnosis, wherever it can be asked for.
#pragma once

#include "host/gap/scan/diagnose_scan.hpp"

namespace umov::cli {

/// A quick answer: a quarter of the draws, a small beam, few refits, thinned records.
void make_quick(gap::scan::ScanDiagnoseOptions& options);

}  // namespace umov::cli
