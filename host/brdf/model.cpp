#include "host/brdf/model.hpp"

#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <utility>

#include "host/brdf/catalogue.hpp"
#include "host/errors/error.hpp"

namespace umov::brdf {
namespace {

template <class Range, class Name>
std::string listing(const Range& range, Name name) {
  std::string text;
  for (const auto& item : range) {
    if (!text.empty()) text += ", ";
    text += name(item);
  }
  return text.empty() ? "none" : text;
}

std::string model_listing() {
  return listing(catalogue(), [](const CatalogueEntry& e) { return std::string(e.name); });
}

std::vector<std::string_view> split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  while (true) {
    const auto end = text.find(separator);
    parts.push_back(text.substr(0, end));
    if (end == std::string_view::npos) return parts;
    text.remove_prefix(end + 1);
  }
}

const CatalogueEntry& entry_named(std::string_view name) {
  for (const CatalogueEntry& entry : catalogue()) {
    if (entry.name == name) return entry;
  }
  throw Error(fmt::format("no model '{}'", name), "there are " + model_listing());
}

std::string_view kind_name(Kind kind) {
  for (const CatalogueEntry& entry : catalogue()) {
    if (entry.kind == kind) return entry.name;
  }
  return {};
}

[[noreturn]] void refuse_choice(std::string_view model, std::string_view choice,
                                std::string_view value, const std::vector<Choice>& choices) {
  throw Error(fmt::format("model '{}' has no choice {}={}", model, choice, value),
              "its choices: " + listing(choices, [](const Choice& c) {
                return c.name + "=" + fmt::format("{}", fmt::join(c.values, "|"));
              }));
}

Component parse_component(std::string_view text) {
  const auto colon = text.find(':');
  const std::string_view name = text.substr(0, colon);
  Component component;
  bool known = false;
  for (const CatalogueEntry& entry : catalogue()) {
    if (entry.name != name) continue;
    component = default_component(entry.kind);
    known = true;
  }
  for (const AliasEntry& alias : alias_entries()) {
    if (alias.name != name) continue;
    component = parse_component(alias.model);
    known = true;
  }
  if (!known) {
    throw Error(fmt::format("no model '{}'", name),
                "there are " + model_listing() + ", and sums such as microfacet+lambertian");
  }
  if (colon == std::string_view::npos) return component;
  for (const std::string_view setting : split(text.substr(colon + 1), ',')) {
    const auto equals = setting.find('=');
    const std::string_view choice = setting.substr(0, equals);
    const std::string_view value =
        equals == std::string_view::npos ? std::string_view{} : setting.substr(equals + 1);
    if (!choose(component, choice, value))
      refuse_choice(name, choice, value, choices_of(component));
  }
  return component;
}

std::string component_name(const Component& component) {
  const std::vector<Choice> defaults = choices_of(default_component(component.kind));
  const std::vector<Choice> chosen = choices_of(component);
  std::string text(kind_name(component.kind));
  char separator = ':';
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    if (chosen[i].value == defaults[i].value) continue;
    text += separator + chosen[i].name + "=" + chosen[i].value;
    separator = ',';
  }
  return text;
}

}  // namespace

Model::Model(std::vector<Component> components) : components_(std::move(components)) {
  for (std::size_t i = 0; i < components_.size(); ++i) {
    Component& component = components_[i];
    const std::string prefix = components_.size() > 1 ? fmt::format("{}.", i) : "";
    name_ += (i == 0 ? "" : "+") + component_name(component);
    component.first = parameters_.size();
    for (Parameter& parameter : parameters_of(component)) {
      parameter.name = prefix + parameter.name;
      parameters_.push_back(std::move(parameter));
    }
    component.count = parameters_.size() - component.first;
    for (Choice& choice : choices_of(component)) {
      choice.name = prefix + choice.name;
      choices_.push_back(std::move(choice));
    }
    if (component.kind == Kind::tabulated)
      table_slots_.push_back({prefix + "file", i, component.table != nullptr});
  }
}

Model Model::by_name(const std::string& name) {
  std::vector<Component> components;
  for (const std::string_view part : split(name, '+')) components.push_back(parse_component(part));
  return Model(std::move(components));
}

std::vector<std::string> Model::names() {
  std::vector<std::string> list;
  for (const CatalogueEntry& entry : catalogue()) list.emplace_back(entry.name);
  return list;
}

std::vector<Alias> Model::aliases() {
  std::vector<Alias> list;
  for (const AliasEntry& entry : alias_entries()) {
    list.push_back({std::string(entry.name), std::string(entry.model), std::string(entry.meaning)});
  }
  return list;
}

std::string Model::description(std::string_view name) {
  return std::string(entry_named(name).description);
}

std::string Model::formula(std::string_view name) {
  return std::string(entry_named(name).formula);
}

std::string Model::remarks(std::string_view name) {
  return std::string(entry_named(name).remarks);
}

bool Model::has_choice(std::string_view choice) const {
  for (const Choice& c : choices_) {
    if (c.name == choice) return true;
  }
  return false;
}

Model Model::with_choice(std::string_view choice, std::string_view value) const {
  std::vector<Component> components = components_;
  for (std::size_t i = 0; i < components.size(); ++i) {
    const std::string prefix = components.size() > 1 ? fmt::format("{}.", i) : "";
    if (choice.starts_with(prefix) && choose(components[i], choice.substr(prefix.size()), value)) {
      return Model(std::move(components));
    }
  }
  refuse_choice(name_, choice, value, choices_);
}

bool Model::needs_table() const {
  for (const TableSlot& slot : table_slots_) {
    if (!slot.filled) return true;
  }
  return false;
}

Model Model::with_table(std::shared_ptr<const Table> table, std::size_t part) const {
  if (part >= components_.size() || components_[part].kind != Kind::tabulated) {
    throw Error(
        fmt::format("part {} of model '{}' takes no table", part, name_),
        "parts count from 0; those that take one: " +
            listing(table_slots_, [](const TableSlot& s) { return std::to_string(s.part); }));
  }
  if (!table) throw Error("no table was given to model '" + name_ + "'", "read one from a file");
  std::vector<Component> components = components_;
  components[part].table = std::move(table);
  return Model(std::move(components));
}

void refuse_missing_table(const Model& model) {
  std::string settings;
  for (const TableSlot& slot : model.table_slots()) {
    if (!slot.filled) settings += " --set " + slot.name + "=PATH";
  }
  throw Error(fmt::format("model '{}' has no table to take its values from", model.name()),
              "name a file of BRDF values:" + settings + " (from C++: Model::with_table)");
}

std::size_t Model::index_of(std::string_view parameter) const {
  for (std::size_t i = 0; i < parameters_.size(); ++i) {
    if (parameters_[i].name == parameter) return i;
  }
  std::string remedy = "it has " + listing(parameters_, [](const Parameter& p) { return p.name; });
  if (!choices_.empty()) {
    remedy += "; choices: " + listing(choices_, [](const Choice& c) {
                return c.name + "=" + fmt::format("{}", fmt::join(c.values, "|"));
              });
  }
  if (!table_slots_.empty())
    remedy += "; tables: " + listing(table_slots_, [](const TableSlot& s) { return s.name; });
  throw Error(fmt::format("model '{}' has no parameter '{}'", name_, parameter), remedy);
}

std::vector<double> Model::initial_values() const {
  std::vector<double> values;
  for (const Parameter& parameter : parameters_) values.push_back(parameter.initial);
  return values;
}

void Model::check(std::span<const double> values) const {
  if (values.size() != parameters_.size()) {
    throw Error(fmt::format("model '{}' got {} values for {} parameters", name_, values.size(),
                            parameters_.size()),
                "give " + listing(parameters_, [](const Parameter& p) { return p.name; }));
  }
  for (std::size_t i = 0; i < values.size(); ++i) {
    const Parameter& p = parameters_[i];
    if (values[i] >= p.min && values[i] <= p.max) continue;
    throw Error(
        fmt::format("{} = {} is outside the range of model '{}'", p.name, values[i], name_),
        fmt::format("{}: {} to {}{}", p.meaning, p.min, p.max, p.unit == "1" ? "" : " " + p.unit));
  }
}

}  // namespace umov::brdf
