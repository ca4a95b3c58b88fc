// Declared tolerances beside the sizes that a diagnosis names.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/gap/engine/diagnosis.hpp"

namespace umov::gap {

/// A size of an effect's parameter, of either sign, that was declared to be in order.
struct SizeLimit {
  std::string effect, parameter;
  double limit = 0;
};

/// Whether every parameter of the cause for which a limit was declared keeps within it; nullopt
/// where none was.
std::optional<bool> within_tolerance(const Cause& cause, const std::vector<SizeLimit>& limits);

}  // namespace umov::gap
