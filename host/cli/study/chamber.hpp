// The study `chamber`: how good must a BRDF be for a luminance map, how good for an intensity
// distribution? [M]'s table 1 and figures 5, 6 and 9 with a virtual measurement.
#pragma once

#include "host/cli/study/study.hpp"

namespace umov::study {

Page chamber(const Options& options);

}  // namespace umov::study
