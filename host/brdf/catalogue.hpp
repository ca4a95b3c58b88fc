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
  std::string_view formula;
  std::string_view remarks;                    ///< energy, reciprocity, limits
  std::span<const Shadowing> shadowings = {};  ///< what the choice offers, the default first
  std::span<const Slopes> slopes = {};
  std::span<const Psd> psds = {};
};

struct AliasEntry {
  std::string_view name, model, meaning;
};

/// In the order in which users see them.
std::span<const CatalogueEntry> catalogue();

std::span<const AliasEntry> alias_entries();

/// A component of this kind with the default of every choice.
Component default_component(Kind kind);

/// Parameters of one component, in the order in which its formula reads them, without a prefix.
std::vector<Parameter> parameters_of(const Component& component);

/// Choices of one component, without a prefix.
std::vector<Choice> choices_of(const Component& component);

/// Makes a choice by name. False when the component has no such choice or it has no such value.
bool choose(Component& component, std::string_view choice, std::string_view value);

}  // namespace umov::brdf
