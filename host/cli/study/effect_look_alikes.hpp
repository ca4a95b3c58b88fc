// What is known beforehand of effects that look alike, and of the scans that tell them apart.
#pragma once

#include <string>
#include <string_view>

namespace umov::study {

struct LookAlikes {
  std::string_view effect;
  std::string_view sign;    ///< of the parameters, where it is a convention
  std::string_view others;  ///< what it is taken for in a plain scan in the plane of incidence
  std::string_view tells;   ///< what separates them; empty: nothing on the menu
};

/// Null for an effect that the table does not know.
const LookAlikes* look_alikes_of(std::string_view effect);

}  // namespace umov::study
