// The study `pointing`: the engine of the diagnosis on a real instrument with real unknown errors.
#pragma once

#include "host/cli/study/study.hpp"

namespace umov::study {

/// Two pointing runs of a telescope, with all terms of the pointing model withheld and with each in
/// turn: which are named, and the RMS before and after. Reads mmt_pointing/ of the folder in
/// UMOV_DATA. Throws umov::Error where it is not there.
Page pointing(const Options& options);

}  // namespace umov::study
