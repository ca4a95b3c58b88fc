#include "host/cli/effects_text.hpp"

#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/gap/answer/words.hpp"
#include "host/gap/scan/effect_list.hpp"

namespace umov::cli {
namespace {

std::string unit_of(const gap::Parameter& p) {
  return p.unit == "1" ? "" : " / " + p.unit;
}

}  // namespace

std::vector<gap::Effect> scan_effects() {
  gap::scan::Scale scale;
  scale.wavelengths_nm = {532, 633, 814};
  return gap::scan::catalogue(scale);
}

void print_effects(const std::vector<gap::Effect>& effects, bool json) {
  if (json) {
    auto list = nlohmann::ordered_json::array();
    for (const gap::Effect& e : effects) {
      nlohmann::ordered_json entry{{"effect", e.name}};
      if (!e.family.empty()) entry["family"] = e.family;
      entry["stage"] = e.stage;
      entry["physics"] = e.physics;
      entry["source"] = e.source;
      entry["parameters"] = nlohmann::ordered_json::array();
      for (const gap::Parameter& p : e.parameters)
        entry["parameters"].push_back({{"name", p.name}, {"unit", p.unit}, {"meaning", p.meaning}});
      list.push_back(std::move(entry));
    }
    fmt::print("{}\n", list.dump(1));
    return;
  }
  for (const gap::Effect& e : effects) {
    fmt::print("{}{}  [{}]\n  {} ({})\n", e.name, e.family.empty() ? "" : " (" + e.family + ")",
               e.stage, e.physics, e.source);
    if (gap::is_series(e.parameters.size())) {
      fmt::print("    {} to {}: {}\n", e.parameters.front().name, e.parameters.back().name,
                 e.parameters.front().meaning);
      continue;
    }
    for (const gap::Parameter& p : e.parameters)
      fmt::print("    {}{}: {}\n", p.name, unit_of(p), p.meaning);
  }
}

}  // namespace umov::cli
