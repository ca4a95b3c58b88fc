#include "host/toml/scene_table.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>

#include "host/errors/error.hpp"
#include "host/toml/spectrum.hpp"

namespace umov {
namespace {

// A sum of decimal numbers of this size without what it has behind their twelfth digit: .6 is not
// .6000000000000001, and -.3 and thrice .1 are 0.
double plain(double sum, double size) {
  const double places = 12.0 - std::ceil(std::log10(size));
  return std::stod(fmt::format("{:.{}f}", sum, static_cast<int>(std::clamp(places, 0.0, 300.0))));
}

}  // namespace

void SceneTable::fail(std::string_view key, const std::string& problem,
                      const std::string& remedy) const {
  const toml::node* at = table_.get(key);
  const auto line = at != nullptr ? at->source().begin.line : table_.source().begin.line;
  const std::string full = name_.empty() ? std::string(key) : name_ + "." + std::string(key);
  throw Error(Place{file_, line}, full + " " + problem, remedy);
}

const toml::node& SceneTable::node(std::string_view key) {
  known_.emplace(key);
  const toml::node* found = table_.get(key);
  if (found == nullptr) fail(key, "is missing", "add it");
  return *found;
}

SceneTable SceneTable::table(std::string_view key) {
  const toml::table* inner = node(key).as_table();
  if (inner == nullptr) fail(key, "is no table", "write [" + std::string(key) + "]");
  return {*inner, file_, name_.empty() ? std::string(key) : name_ + "." + std::string(key)};
}

std::vector<SceneTable> SceneTable::tables(std::string_view key) {
  known_.emplace(key);
  std::vector<SceneTable> all;
  const toml::node* found = table_.get(key);
  if (found == nullptr) return all;
  const toml::array* list = found->as_array();
  if (list == nullptr) {
    fail(key, "is no list of tables", "write [[" + std::string(key) + "]]");
  }
  for (const toml::node& entry : *list) {
    if (entry.as_table() == nullptr) {
      fail(key, "is no list of tables", "write [[" + std::string(key) + "]]");
    }
    all.emplace_back(*entry.as_table(), file_,
                     std::string(key) + "[" + std::to_string(all.size()) + "]");
  }
  return all;
}

std::string SceneTable::text(std::string_view key) {
  const auto value = node(key).value_exact<std::string>();
  if (!value) fail(key, "is no text", "put it in quotes");
  return *value;
}

std::filesystem::path SceneTable::file(std::string_view key) {
  const std::string name = text(key);
  const std::filesystem::path beside = std::filesystem::path(file_).parent_path() / name;
  for (const auto& path : {beside, std::filesystem::path(name)}) {
    if (std::ifstream(path)) return path;
  }
  fail(key, "is '" + name + "', which cannot be read",
       "there is no readable " + beside.string() + "; check the name");
}

std::string SceneTable::text(std::string_view key, const std::vector<std::string>& permitted,
                             std::optional<std::string> preset) {
  known_.emplace(key);
  std::string value = preset && !has(key) ? *preset : text(key);
  if (std::find(permitted.begin(), permitted.end(), value) == permitted.end()) {
    fail(key, "is '" + value + "'", fmt::format("choose one of: {}", fmt::join(permitted, ", ")));
  }
  return value;
}

double SceneTable::checked(const toml::node& value, std::string_view key, double low,
                           double high) const {
  const auto number = value.is_number() ? value.value<double>() : std::nullopt;
  if (!number) fail(key, "is no number", "give a number");
  if (!(*number >= low && *number <= high)) {
    fail(key, fmt::format("= {} is out of range", *number),
         fmt::format("choose {} to {}", low, high));
  }
  return *number;
}

double SceneTable::number(std::string_view key, double low, double high,
                          std::optional<double> preset) {
  known_.emplace(key);
  if (preset && !has(key)) return *preset;
  return checked(node(key), key, low, high);
}

std::vector<double> SceneTable::spectrum(std::string_view key,
                                         const std::vector<double>& wavelengths_um, double low,
                                         double high) {
  const toml::node& value = node(key);
  std::vector<double> values;
  if (value.is_table()) {
    SceneTable inner = table(key);
    Spectrum known;
    if (inner.has("file")) {
      const std::filesystem::path path = inner.file("file");
      known = read_spectrum(path, inner.text("column"));
    } else {
      constexpr double unlimited = std::numeric_limits<double>::max();
      const bool nm = inner.has("wavelength_nm");
      known.wavelength_um = inner.numbers(nm ? "wavelength_nm" : "wavelength_um", 0.0, unlimited);
      if (nm) {
        for (double& w : known.wavelength_um) w *= 1e-3;
      }
      known.value = inner.numbers("value", -unlimited, unlimited);
      if (known.value.size() != known.wavelength_um.size() ||
          !std::is_sorted(known.wavelength_um.begin(), known.wavelength_um.end(),
                          std::less_equal<>())) {
        inner.fail("value",
                   fmt::format("has {} values for {} wavelengths, or these do not rise",
                               known.value.size(), known.wavelength_um.size()),
                   "give one a wavelength, in ascending order");
      }
    }
    inner.refuse_unknown();
    for (const double w : wavelengths_um) {
      try {
        values.push_back(known.at(w, std::string(key)));
      } catch (const Error& e) {
        fail(key, "does not reach: " + e.problem(), e.remedy());
      }
      if (!(values.back() >= low && values.back() <= high)) {
        fail(key, fmt::format("= {} at {} um is out of range", values.back(), w),
             fmt::format("choose {} to {}", low, high));
      }
    }
    return values;
  }
  return spectrum(key, wavelengths_um.size(), low, high);
}

std::vector<double> SceneTable::spectrum(std::string_view key, std::size_t count, double low,
                                         double high) {
  const toml::node& value = node(key);
  const toml::array* list = value.as_array();
  if (list == nullptr) return std::vector<double>(count, checked(value, key, low, high));
  if (list->size() != count) {
    fail(key, fmt::format("has {} values for {} wavelengths", list->size(), count),
         "give one a wavelength, or one for all");
  }
  std::vector<double> values;
  for (const toml::node& entry : *list) values.push_back(checked(entry, key, low, high));
  return values;
}

bool SceneTable::flag(std::string_view key, bool preset) {
  known_.emplace(key);
  if (!has(key)) return preset;
  const auto value = node(key).value_exact<bool>();
  if (!value) fail(key, "is neither true nor false", "write one of them");
  return *value;
}

std::vector<double> SceneTable::numbers(std::string_view key, double low, double high) {
  const toml::node& value = node(key);
  std::vector<double> values;
  if (value.is_table()) {
    SceneTable range = table(key);
    const double from = range.number("from", low, high);
    const double to = range.number("to", from, high);
    const double step = range.number("step", 1e-6 * high, high);
    range.refuse_unknown();
    const double steps = std::floor((to - from) / step + 1e-9);
    if (steps > 1000.0) fail(key, "has more than 1000 values", "use a longer step");
    const double size = std::max({std::abs(from), std::abs(to), step});
    for (int i = 0; i <= static_cast<int>(steps); ++i)
      values.push_back(plain(from + i * step, size));
  } else if (const toml::array* list = value.as_array()) {
    for (const toml::node& entry : *list) values.push_back(checked(entry, key, low, high));
  } else {
    values.push_back(checked(value, key, low, high));
  }
  if (values.empty()) fail(key, "is empty", "give at least one number");
  return values;
}

void SceneTable::refuse_unknown() const {
  for (const auto& [key, value] : table_) {
    if (!known_.contains(key.str())) {
      auto all = known_;
      all.insert(asked_.begin(), asked_.end());
      fail(key.str(), "is not known here", fmt::format("known are: {}", fmt::join(all, ", ")));
    }
  }
}

}  // namespace umov
