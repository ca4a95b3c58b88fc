// Reading typed, bounded values from a TOML table, with the place of everything that is wrong.
#pragma once

#include <toml++/toml.h>

#include <cstddef>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace umov::scan {

/// Nearest of `known` by edit distance; empty where none is near.
std::string nearest_name(std::string_view name, const std::vector<std::string>& known);

/// Permitted numbers, inclusive unless `above` is set (then `lowest` itself is not permitted).
struct Limits {
  double lowest, highest;
  const char* unit;
  bool above = false;
};

/// One table of a plan. Every getter notes its key as known; `refuse_unknown` then refuses the
/// rest.
class PlanTable {
 public:
  /// `path` names the table in messages, "" for the whole file.
  PlanTable(const toml::table& table, const std::string& file, std::string path);

  const toml::node* find(std::string_view key);
  std::optional<std::string> text(std::string_view key);
  std::optional<std::string> choice(std::string_view key,
                                    const std::vector<std::string>& permitted);
  std::optional<double> number(std::string_view key, const Limits& limits);
  std::optional<std::int64_t> integer(std::string_view key, const Limits& limits);
  /// A number, a list of numbers or `{ from, to, step }`. Not empty.
  std::optional<std::vector<double>> numbers(std::string_view key, const Limits& limits);
  /// The numbers of `{ from, to, step }`, whose keys this table holds.
  std::vector<double> range(const Limits& limits);

  void refuse_unknown() const;
  [[noreturn]] void fail(const toml::node& at, std::string_view key, const std::string& problem,
                         const std::string& remedy) const;
  const toml::table& toml() const { return table_; }
  const std::string& file() const { return file_; }
  std::string full_name(std::string_view key) const;

  /// A finite number within limits, or an error at that node.
  double checked_number(const toml::node& node, std::string_view key, const Limits& limits) const;

 private:
  const toml::table& table_;
  const std::string& file_;
  std::string path_;
  std::set<std::string, std::less<>> known_;
};

std::size_t line_of(const toml::node& node);

}  // namespace umov::scan
