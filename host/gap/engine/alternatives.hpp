// What a cause's rivals would be like in its place.
#pragma once

#include <string>
#include <vector>

#include "host/gap/engine/diagnosis.hpp"
#include "host/gap/engine/forward_model.hpp"

namespace umov::gap {

struct Alternative {
  std::string instead_of;  ///< the effect of the best explanation
  Effect effect;
  std::vector<NamedValue> parameters;  ///< with their 95 % intervals
};

/// Of the diagnosis' rivals those effects that the best explanation does not have.
std::vector<Alternative> alternatives_of(const ForwardModel& model, const Diagnosis& diagnosis);

}  // namespace umov::gap
