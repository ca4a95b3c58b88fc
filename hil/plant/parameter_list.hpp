// The parameters of the plant by name: the one place that files, command lines and documentation
// use.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hil/plant/plant_config.hpp"

namespace umov::plant {

/// A parameter bound to one PlantConfig, which must outlive it.
struct Parameter {
  std::string name;  ///< dotted path: "axis.detector.zero_deg"
  double* value;
  double low, high;  ///< allowed range
  std::string unit;
  std::string meaning;
};

/// All parameters of `config`, in the order of the tree.
std::vector<Parameter> parameters(PlantConfig& config);

/// Sets one parameter from "name=value". Throws umov::Error for an unknown name (with the nearest
/// known one), a value that is not a number, or one out of range.
void apply_override(PlantConfig& config, std::string_view assignment);

/// Preset, then overrides in order.
PlantConfig make_config(const std::string& preset, std::span<const std::string> overrides = {});

/// Reads a TOML file of parameters: `preset = "ideal"` (default) or "realistic" as the base, then
/// tables as in the names ("[axis.detector]", "zero_deg = 0.1"). Unknown keys, texts and values out
/// of range are refused with file and line.
PlantConfig config_from_file(const std::string& path);
PlantConfig config_from_toml(std::string_view text, const std::string& origin);

/// The reference of all parameters as a Markdown table: name, unit, ideal, realistic, meaning.
std::string parameter_reference();

}  // namespace umov::plant
