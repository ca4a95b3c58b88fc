// Measurements that other people made: do models fitted in the plane of incidence foretell what the
// instruments saw out of it?
#pragma once

#include "host/cli/study/study.hpp"

namespace umov::study {

/// Reads nist_ptfe/ and cornell_paint/ of the folder in UMOV_DATA, where it names none of
/// tests/data. Samples that are not there are skipped and named. Throws umov::Error where none is.
Page real_data(const Options& options);

}  // namespace umov::study
