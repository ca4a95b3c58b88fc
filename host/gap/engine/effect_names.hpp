// Effects by the names that files and command lines use.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "host/gap/engine/forward_model.hpp"

namespace umov::gap {

/// Numbers of the effects of these names, all members of a family included. Throws umov::Error for
/// a name that none has.
std::vector<std::size_t> effects_named(const std::vector<std::string>& names,
                                       const std::vector<Effect>& effects);

}  // namespace umov::gap
