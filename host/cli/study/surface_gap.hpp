// The study `surface-gap`: what linear mixing in single bounce leaves out of dirty, wet and rough
// surfaces, named from their BRDF alone.
#pragma once

#include "host/cli/study/study.hpp"

namespace umov::study {

Page surface_gap(const Options& options);

}  // namespace umov::study
