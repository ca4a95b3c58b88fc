// The contaminants paper repeated: soil on a paint, water drops on another ([C], docs/physics.md,
// 4).
#pragma once

#include "host/cli/study/study.hpp"

namespace umov::study {

/// Figures 4 to 9 of the paper as virtual measurements, and each of its statements with a number.
Page contaminants(const Options& options);

}  // namespace umov::study
