// The virtual repetition of the reflectometer paper [R]: its tables 2 to 4 and figures 6, 8, 9 and
// 11 as measurements on the emulated instrument, beside the paper's numbers and the truth.
#pragma once

#include "host/cli/study/study.hpp"

namespace umov::study {

Page reflectometer(const Options& options);

}  // namespace umov::study
