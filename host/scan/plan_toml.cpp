#include "host/scan/plan_toml.hpp"

#include <algorithm>
#include <cmath>

#include "host/errors/error.hpp"
#include "host/formats/decimal.hpp"

namespace umov::scan {
namespace {

constexpr double most_range_entries = 100'000;

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t above = row[j];
      row[j] = std::min({above + 1, row[j - 1] + 1, diagonal + (a[i - 1] == b[j - 1] ? 0 : 1)});
      diagonal = above;
    }
  }
  return row[b.size()];
}

std::string limits_text(const Limits& limits) {
  return (limits.above ? "above " : "") + formats::decimal_text(limits.lowest) + " to " +
         formats::decimal_text(limits.highest) +
         (*limits.unit == '\0' ? "" : std::string(" ") + limits.unit);
}

}  // namespace

std::size_t line_of(const toml::node& node) {
  return node.source().begin.line;
}

std::string nearest_name(std::string_view name, const std::vector<std::string>& known) {
  name = name.substr(0, 64);
  std::string best;
  std::size_t best_distance = std::max<std::size_t>(2, name.size() / 2) + 1;
  for (const std::string& candidate : known) {
    std::size_t distance = edit_distance(name, candidate);
    // "theta_i" for "theta_i_deg" is nearer than its distance says.
    if (name.size() >= 3 && candidate.starts_with(name)) distance = 1;
    if (distance < best_distance) {
      best_distance = distance;
      best = candidate;
    }
  }
  return best;
}

PlanTable::PlanTable(const toml::table& table, const std::string& file, std::string path)
    : table_(table), file_(file), path_(std::move(path)) {}

std::string PlanTable::full_name(std::string_view key) const {
  return path_.empty() ? std::string(key) : path_ + "." + std::string(key);
}

void PlanTable::fail(const toml::node& at, std::string_view key, const std::string& problem,
                     const std::string& remedy) const {
  throw Error(Place{file_, line_of(at), full_name(key)}, problem, remedy);
}

const toml::node* PlanTable::find(std::string_view key) {
  known_.emplace(key);
  return table_.get(key);
}

std::optional<std::string> PlanTable::text(std::string_view key) {
  const toml::node* node = find(key);
  if (node == nullptr) return std::nullopt;
  const std::optional<std::string> value = node->value_exact<std::string>();
  if (!value) fail(*node, key, "is not a text", "write it between quotation marks");
  for (const char c : *value)
    if (static_cast<unsigned char>(c) < 32)
      fail(*node, key, "holds a line break or control character", "write it in one line");
  return value;
}

std::optional<std::string> PlanTable::choice(std::string_view key,
                                             const std::vector<std::string>& permitted) {
  const std::optional<std::string> value = text(key);
  if (!value || std::find(permitted.begin(), permitted.end(), *value) != permitted.end())
    return value;
  std::string all;
  for (const std::string& name : permitted) all += (all.empty() ? "" : ", ") + name;
  const std::string near = nearest_name(*value, permitted);
  fail(*table_.get(key), key, "\"" + *value + "\" is none of " + all,
       near.empty() ? "choose one of them" : "did you mean \"" + near + "\"?");
}

double PlanTable::checked_number(const toml::node& node, std::string_view key,
                                 const Limits& limits) const {
  const std::optional<double> value = node.is_number() ? node.value<double>() : std::nullopt;
  if (!value) fail(node, key, "is not a number", "permitted: " + limits_text(limits));
  if (!std::isfinite(*value) || *value < limits.lowest || *value > limits.highest ||
      (limits.above && *value == limits.lowest))
    fail(node, key, formats::decimal_text(*value) + " is outside the limits",
         "permitted: " + limits_text(limits));
  return *value;
}

std::optional<double> PlanTable::number(std::string_view key, const Limits& limits) {
  const toml::node* node = find(key);
  if (node == nullptr) return std::nullopt;
  return checked_number(*node, key, limits);
}

std::optional<std::int64_t> PlanTable::integer(std::string_view key, const Limits& limits) {
  const toml::node* node = find(key);
  if (node == nullptr) return std::nullopt;
  const double value = checked_number(*node, key, limits);
  if (value != std::floor(value)) fail(*node, key, "is not a whole number", "drop the decimals");
  return static_cast<std::int64_t>(value);
}

std::vector<double> PlanTable::range(const Limits& limits) {
  const auto wanted = [&](std::string_view key) {
    const std::optional<double> value =
        key == "step" ? number(key, {0, 1e6, limits.unit, true}) : number(key, limits);
    if (!value)
      throw Error(Place{file_, line_of(table_), full_name(key)}, "the key is missing",
                  "a range is { from = …, to = …, step = … }");
    return *value;
  };
  const double from = wanted("from");
  const double to = wanted("to");
  const double step = wanted("step");
  if (to < from)
    fail(*table_.get("to"), "to", "is below `from`: the range is empty", "exchange the two");
  const double steps = std::floor((to - from) / step + 1e-9);
  if (steps >= most_range_entries)
    fail(*table_.get("step"), "step", "gives more than 100000 values", "take a larger step");
  std::vector<double> values;
  for (int i = 0; i <= static_cast<int>(steps); ++i)
    values.push_back(std::round((from + i * step) * 1e6) / 1e6 + 0.0);
  return values;
}

std::optional<std::vector<double>> PlanTable::numbers(std::string_view key, const Limits& limits) {
  const toml::node* node = find(key);
  if (node == nullptr) return std::nullopt;
  if (const toml::table* table = node->as_table()) {
    PlanTable inner(*table, file_, full_name(key));
    const std::vector<double> values = inner.range(limits);
    inner.refuse_unknown();
    return values;
  }
  if (const toml::array* list = node->as_array()) {
    if (list->empty()) fail(*node, key, "the list is empty", "give at least one number");
    std::vector<double> values;
    for (const toml::node& item : *list) values.push_back(checked_number(item, key, limits));
    return values;
  }
  return std::vector<double>{checked_number(*node, key, limits)};
}

void PlanTable::refuse_unknown() const {
  for (const auto& [key, node] : table_) {
    if (known_.contains(key.str())) continue;
    const std::vector<std::string> known(known_.begin(), known_.end());
    const std::string near = nearest_name(key.str(), known);
    std::string all;
    for (const std::string& name : known) all += (all.empty() ? "" : ", ") + name;
    throw Error(Place{file_, key.source().begin.line, full_name(key.str())},
                "unknown key \"" + std::string(key.str()) + "\"",
                near.empty() ? "known keys: " + all : "did you mean \"" + near + "\"?");
  }
}

}  // namespace umov::scan
