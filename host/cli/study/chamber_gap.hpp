// The study `chamber-gap`: what a simulated luminance map has wrong, named from the map alone.
#pragma once

#include "host/cli/study/study.hpp"

namespace umov::study {

Page chamber_gap(const Options& options);

}  // namespace umov::study
