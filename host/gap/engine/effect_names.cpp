#include "host/gap/engine/effect_names.hpp"

#include <algorithm>

#include "host/errors/error.hpp"

namespace umov::gap {
namespace {

/// "a, b, c", each name once.
std::string listed(const std::vector<Effect>& effects) {
  std::vector<std::string> known;
  std::string text;
  for (const Effect& e : effects) {
    if (std::find(known.begin(), known.end(), e.name) != known.end()) continue;
    text += (known.empty() ? "" : ", ") + e.name;
    known.push_back(e.name);
  }
  return text;
}

}  // namespace

std::vector<std::size_t> effects_named(const std::vector<std::string>& names,
                                       const std::vector<Effect>& effects) {
  std::vector<std::size_t> numbers;
  for (const std::string& name : names) {
    const std::size_t before = numbers.size();
    for (std::size_t e = 0; e < effects.size(); ++e)
      if (effects[e].name == name) numbers.push_back(e);
    if (numbers.size() == before)
      throw Error("no effect is called \"" + name + "\"", "choose from: " + listed(effects));
  }
  return numbers;
}

}  // namespace umov::gap
