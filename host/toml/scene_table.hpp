// Typed, bounded values from one table of a scene file.
#pragma once

#include <toml++/toml.h>

#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace umov {

/// Every getter notes its key as known; refuse_unknown() refuses the rest. All throw umov::Error
/// with file and line.
class SceneTable {
 public:
  SceneTable(const toml::table& table, const std::string& file, std::string name)
      : table_(table), file_(file), name_(std::move(name)) {}

  bool has(std::string_view key) const {
    asked_.emplace(key);
    return table_.contains(key);
  }
  bool is_list(std::string_view key) const { return table_[key].is_array(); }
  /// A table inside; `key` must be there.
  SceneTable table(std::string_view key);
  std::vector<SceneTable> tables(std::string_view key);
  std::string text(std::string_view key, const std::vector<std::string>& permitted,
                   std::optional<std::string> preset = {});
  bool flag(std::string_view key, bool preset);
  std::string text(std::string_view key);
  /// A file's name, from where the scene file is or else from where the program runs; refused where
  /// it cannot be read.
  std::filesystem::path file(std::string_view key);
  double number(std::string_view key, double low, double high, std::optional<double> preset = {});
  /// A number or a list of `count` numbers; the former is repeated.
  std::vector<double> spectrum(std::string_view key, std::size_t count, double low, double high);
  /// A value for each of the wavelengths (µm) from a number, a list with one number a wavelength,
  /// { wavelength_um = […], value = […] } (or wavelength_nm) or { file = "…", column = "…" }, the
  /// file's name from where the scene file is.
  std::vector<double> spectrum(std::string_view key, const std::vector<double>& wavelengths_um,
                               double low, double high);
  /// A list of numbers or { from, to, step }.
  std::vector<double> numbers(std::string_view key, double low, double high);
  void refuse_unknown() const;
  [[noreturn]] void fail(std::string_view key, const std::string& problem,
                         const std::string& remedy) const;
  const toml::table& toml() const { return table_; }
  void know(std::string_view key) { known_.emplace(key); }

 private:
  const toml::node& node(std::string_view key);
  double checked(const toml::node& value, std::string_view key, double low, double high) const;

  const toml::table& table_;
  const std::string& file_;
  std::string name_;
  std::set<std::string, std::less<>> known_;
  mutable std::set<std::string, std::less<>> asked_;  // for by has(): named to those who misspell
};

}  // namespace umov
