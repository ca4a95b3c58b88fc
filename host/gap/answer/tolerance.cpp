#include "host/gap/answer/tolerance.hpp"

#include <cmath>

namespace umov::gap {

std::optional<bool> within_tolerance(const Cause& cause, const std::vector<SizeLimit>& limits) {
  std::optional<bool> within;
  for (const SizeLimit& l : limits) {
    if (l.effect != cause.effect) continue;
    for (const NamedValue& p : cause.parameters)
      if (p.name == l.parameter)
        within = within.value_or(true) && std::abs(p.interval.value) <= l.limit;
  }
  return within;
}

}  // namespace umov::gap
