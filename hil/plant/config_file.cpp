// PlantConfig from TOML: tables become dotted names.
#include <cmath>
#include <fstream>
#include <sstream>

#include "hil/plant/parameter_list.hpp"
#include "hil/plant/parameter_setting.hpp"
#include "host/errors/error.hpp"
#include "host/toml/parse.hpp"

namespace umov::plant {
namespace {

void apply_table(PlantConfig& config, const toml::table& table, const std::string& prefix,
                 const std::string& origin) {
  for (const auto& [key, node] : table) {
    const std::string name = prefix + std::string(key.str());
    const Place place{origin, node.source().begin.line, {}};
    if (name == "preset") continue;
    if (const toml::table* inner = node.as_table()) {
      apply_table(config, *inner, name + ".", origin);
      continue;
    }
    const auto value = node.value<double>();
    if (!value || node.is_boolean() || !std::isfinite(*value)) {
      throw Error(place, "\"" + name + "\" is not a number", "give a finite number");
    }
    set_parameter(config, name, *value, place);
  }
}

}  // namespace

PlantConfig config_from_toml(std::string_view text, const std::string& origin) {
  const toml::table table = parse_toml(text, origin, "correct the TOML");
  PlantConfig config = ideal_config();
  if (const toml::node* preset = table.get("preset")) {
    const Place place{origin, preset->source().begin.line, {}};
    const auto name = preset->value<std::string>();
    if (!name || (*name != "ideal" && *name != "realistic")) {
      throw Error(place, "\"preset\" is neither \"ideal\" nor \"realistic\"",
                  "name one of the two");
    }
    config = preset_config(*name);
  }
  apply_table(config, table, "", origin);
  return config;
}

PlantConfig config_from_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw Error({path}, "cannot be read", "check the path and its permissions");
  std::ostringstream text;
  text << file.rdbuf();
  return config_from_toml(text.str(), path);
}

}  // namespace umov::plant
