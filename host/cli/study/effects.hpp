// The study `effects`: the catalogue of the diagnosis, each effect with a picture of its signature.
#pragma once

#include "host/cli/study/study.hpp"

namespace umov::study {

/// Every effect of the catalogue at its usual size on a scan of the emulated instrument, before and
/// after the base model has been refitted.
Page effects(const Options& options);

}  // namespace umov::study
