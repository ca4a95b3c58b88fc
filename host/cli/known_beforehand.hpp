// Files that a diagnosis takes as known beforehand: a calibration, tolerances, a fit.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "host/gap/answer/tolerance.hpp"
#include "host/gap/scan/knowledge.hpp"

namespace umov::cli {

struct KnownFiles {
  std::string calibration, tolerances, fit;  ///< empty: none
  bool hold = false;                         ///< the fit's parameters are not fitted again
};

/// Reads them. Throws umov::Error for files that are not what they should be, and for `hold`
/// without a fit.
gap::scan::Knowledge read_known(const KnownFiles& files);

/// As the answer wants them: the first of each parameter.
std::vector<gap::SizeLimit> limits_of(const std::vector<gap::scan::Tolerance>& tolerances);

/// Kind and path of each file that was named.
std::vector<std::pair<std::string, std::string>> list_of(const KnownFiles& files);

}  // namespace umov::cli
