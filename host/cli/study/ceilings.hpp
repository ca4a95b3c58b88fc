// The study `ceilings`: how often any diagnosis could name a single effect.
#pragma once

#include "host/cli/study/study.hpp"

namespace umov::study {

/// Draws effects of known visibility into scans of growing plans and names them with everything
/// known but which effect it is: the forward model, its noise, the priors. What this rate falls
/// short of 1 is the plan's, not a method's.
Page ceilings(const Options& options);

}  // namespace umov::study
