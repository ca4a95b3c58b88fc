// What models exist, with their parameters and choices: the one declaration that the command line,
// files, reports and fits read.
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "host/brdf/model.hpp"

namespace umov::brdf {

struct CatalogueEntry {
  Kind kind;
  std::string_view name;
  std::string_view description;
  bool has_shadowing;      ///< none, vgroove, smith, smith-correlated
  bool has_maxwell_beard;  ///< maxwell-beard as well
  bool has_slopes;         ///< gaussian, exponential
};

/// In the order in which users see them.
std::span<const CatalogueEntry> catalogue();

/// Parameters of one component, in the order in which its formula reads them, without a prefix.
std::vector<Parameter> parameters_of(const Component& component);

/// Choices of one component, without a prefix.
std::vector<Choice> choices_of(const Component& component);

/// Makes a choice by name. False when the component has no such choice or it has no such value.
bool choose(Component& component, std::string_view choice, std::string_view value);

}  // namespace umov::brdf
