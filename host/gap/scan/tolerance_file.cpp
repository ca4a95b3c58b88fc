#include "host/gap/scan/tolerance_file.hpp"

#include <cmath>
#include <numbers>
#include <optional>

#include "host/errors/error.hpp"
#include "host/formats/atomic_file.hpp"
#include "host/toml/parse.hpp"

namespace umov::gap::scan {
namespace {

constexpr const char* remedy =
    "write [effect] on a line of its own and below it parameter = 0.02 (one standard deviation) or "
    "parameter = { half_width = 0.05 }";

std::optional<double> positive(const toml::node* node) {
  if (node == nullptr || !node->is_number()) return std::nullopt;
  const auto value = node->value<double>();
  if (!value || !std::isfinite(*value) || !(*value > 0)) return std::nullopt;
  return value;
}

Tolerance tolerance_of(const std::string& effect, const std::string& parameter,
                       const toml::node& node, const std::string& file) {
  Tolerance t{effect, parameter, 0, 0, file, node.source().begin.line};
  if (const auto u = positive(&node)) {
    t.u = *u;
    t.limit = 2 * *u;
    return t;
  }
  const toml::table* table = node.as_table();
  const auto half_width = table == nullptr ? std::nullopt : positive(table->get("half_width"));
  if (!half_width || table->size() != 1)
    throw Error(Place{file, t.line},
                "the tolerance of " + effect + "." + parameter + " is no positive number", remedy);
  t.u = *half_width / std::numbers::sqrt3;
  t.limit = *half_width;
  return t;
}

}  // namespace

std::vector<Tolerance> read_tolerances(const std::string& file) {
  const toml::table root = parse_toml(formats::read_whole_file(file), file, remedy);
  std::vector<Tolerance> result;
  for (const auto& [effect, node] : root) {
    const toml::table* table = node.as_table();
    if (table == nullptr)
      throw Error(Place{file, node.source().begin.line},
                  std::string(effect.str()) + " is no table of an effect", remedy);
    for (const auto& [parameter, value] : *table)
      result.push_back(
          tolerance_of(std::string(effect.str()), std::string(parameter.str()), value, file));
  }
  if (result.empty()) throw Error(Place{file}, "states no tolerance", remedy);
  return result;
}

}  // namespace umov::gap::scan
