#include "host/optics/refractive_index.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <limits>
#include <sstream>

#include "host/errors/error.hpp"
#include "host/optics/embedded_index.hpp"

namespace umov::optics {
namespace {

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r\n");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r\n") - first + 1);
}

std::size_t indentation(std::string_view line) {
  const auto first = line.find_first_not_of(' ');
  return first == std::string_view::npos ? line.size() : first;
}

/// All numbers of a line; refuses anything else.
std::vector<double> numbers(std::string_view line, const Place& place) {
  std::vector<double> values;
  std::string_view rest = trimmed(line);
  while (!rest.empty()) {
    const std::string_view word = rest.substr(0, rest.find_first_of(" \t"));
    const std::string_view digits = word.starts_with('+') ? word.substr(1) : word;
    double value = 0.0;
    const auto [end, code] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (code != std::errc{} || end != digits.data() + digits.size() || !std::isfinite(value)) {
      throw Error(place, "'" + std::string(word) + "' is not a number",
                  "index data are wavelength in um, n and k, separated by spaces");
    }
    values.push_back(value);
    rest = trimmed(rest.substr(word.size()));
  }
  return values;
}

struct Line {
  std::string_view text;
  std::size_t number;
};

std::vector<Line> lines_of(std::string_view text) {
  std::vector<Line> lines;
  std::size_t number = 0;
  while (!text.empty()) {
    const auto end = text.find('\n');
    lines.push_back({text.substr(0, end), ++number});
    if (end == std::string_view::npos) break;
    text.remove_prefix(end + 1);
  }
  return lines;
}

/// The dispersion formulas of the database; c[0] is the first coefficient, missing ones are 0.
double dispersion(int formula, const std::vector<double>& c, double wavelength_um) {
  const double l2 = wavelength_um * wavelength_um;
  const double first = c.empty() ? 0.0 : c[0];
  const auto coefficient = [&](std::size_t i) { return i < c.size() ? c[i] : 0.0; };
  switch (formula) {
    case 1: {  // Sellmeier, resonances given as wavelengths
      double n2 = 1.0 + first;
      for (std::size_t i = 1; i + 1 < c.size(); i += 2)
        n2 += c[i] * l2 / (l2 - c[i + 1] * c[i + 1]);
      return std::sqrt(n2);
    }
    case 2: {  // Sellmeier, resonances given as squares
      double n2 = 1.0 + first;
      for (std::size_t i = 1; i + 1 < c.size(); i += 2) n2 += c[i] * l2 / (l2 - c[i + 1]);
      return std::sqrt(n2);
    }
    case 3: {  // polynomial in n²
      double n2 = first;
      for (std::size_t i = 1; i + 1 < c.size(); i += 2)
        n2 += c[i] * std::pow(wavelength_um, c[i + 1]);
      return std::sqrt(n2);
    }
    case 4: {  // two resonances, then a polynomial
      double n2 = first;
      for (std::size_t i = 1; i < 9 && i < c.size(); i += 4) {
        n2 += coefficient(i) * std::pow(wavelength_um, coefficient(i + 1)) /
              (l2 - std::pow(coefficient(i + 2), coefficient(i + 3)));
      }
      for (std::size_t i = 9; i + 1 < c.size(); i += 2)
        n2 += c[i] * std::pow(wavelength_um, c[i + 1]);
      return std::sqrt(n2);
    }
    case 5: {  // Cauchy
      double n = first;
      for (std::size_t i = 1; i + 1 < c.size(); i += 2)
        n += c[i] * std::pow(wavelength_um, c[i + 1]);
      return n;
    }
    default: {  // 6, gases
      double n = 1.0 + first;
      for (std::size_t i = 1; i + 1 < c.size(); i += 2) n += c[i] / (c[i + 1] - 1.0 / l2);
      return n;
    }
  }
}

}  // namespace

double IndexTable::Series::at(double wavelength) const {
  const auto above = std::lower_bound(wavelength_um.begin(), wavelength_um.end(), wavelength);
  const auto i = static_cast<std::size_t>(above - wavelength_um.begin());
  if (i == 0) return value.front();
  if (i == wavelength_um.size()) return value.back();
  const double t = (wavelength - wavelength_um[i - 1]) / (wavelength_um[i] - wavelength_um[i - 1]);
  return value[i - 1] + t * (value[i] - value[i - 1]);
}

IndexTable IndexTable::from_text(std::string_view text, const std::string& origin) {
  IndexTable table;
  table.origin_ = origin;
  double n_min = 0.0, n_max = std::numeric_limits<double>::infinity();
  bool has_n = false;
  bool in_data = false;
  bool in_rows = false;
  std::string kind;
  std::size_t block_indent = 0;

  for (const Line& line : lines_of(text)) {
    const std::string_view content = trimmed(line.text);
    const Place place{origin, line.number};
    if (content.empty() || content.starts_with('#')) continue;
    const std::size_t indent = indentation(line.text);
    if (indent == 0) {
      in_data = content == "DATA:";
      in_rows = false;
      continue;
    }
    if (!in_data) continue;
    if (in_rows && indent > block_indent) {
      const std::vector<double> row = numbers(content, place);
      const bool both = kind == "tabulated nk";
      if (row.size() != (both ? 3u : 2u)) {
        throw Error(
            place,
            std::to_string(row.size()) + " numbers where '" + kind + "' has " + (both ? "3" : "2"),
            "give wavelength in um and the values");
      }
      const auto append = [&](Series& series, double value) {
        if (!series.wavelength_um.empty() && !(row[0] > series.wavelength_um.back())) {
          throw Error(place, "wavelengths do not rise", "sort the rows by wavelength");
        }
        series.wavelength_um.push_back(row[0]);
        series.value.push_back(value);
      };
      if (kind == "tabulated n" || both) append(table.n_, row[1]);
      if (kind == "tabulated k" || both) append(table.kappa_, row.back());
      continue;
    }
    in_rows = false;
    std::string_view entry = content;
    if (entry.starts_with("- ")) entry = trimmed(entry.substr(2));
    const auto colon = entry.find(':');
    if (colon == std::string_view::npos) {
      throw Error(place, "expected 'key: value'", "see refractiveindex.info's file format");
    }
    const std::string_view key = entry.substr(0, colon);
    const std::string_view value = trimmed(entry.substr(colon + 1));
    if (key == "type") {
      kind = value;
      if (kind.starts_with("formula ")) {
        if (kind.size() != 9 || kind[8] < '1' || kind[8] > '6') {
          throw Error(place, "unsupported '" + kind + "'", "formulas 1 to 6 and tables are read");
        }
        table.formula_ = kind[8] - '0';
        has_n = true;
      } else if (kind == "tabulated nk" || kind == "tabulated n") {
        has_n = true;
      } else if (kind != "tabulated k") {
        throw Error(place, "unsupported '" + kind + "'", "formulas 1 to 6 and tables are read");
      }
    } else if (key == "data") {
      in_rows = true;
      block_indent = indent;
    } else if (key == "wavelength_range") {
      const std::vector<double> range = numbers(value, place);
      if (range.size() != 2 || !(range[0] < range[1])) {
        throw Error(place, "a wavelength range is two rising numbers", "give both in um");
      }
      n_min = range[0];
      n_max = range[1];
    } else if (key == "coefficients") {
      table.coefficients_ = numbers(value, place);
    }
  }

  if (!has_n || (table.formula_ == 0 && table.n_.value.empty())) {
    throw Error({origin}, "no refractive index in the file",
                "a DATA section with 'tabulated nk', 'tabulated n' or a formula is needed");
  }
  if (table.formula_ == 0) {
    n_min = table.n_.wavelength_um.front();
    n_max = table.n_.wavelength_um.back();
  }
  if (!table.kappa_.value.empty()) {
    n_min = std::max(n_min, table.kappa_.wavelength_um.front());
    n_max = std::min(n_max, table.kappa_.wavelength_um.back());
  }
  table.min_um_ = n_min;
  table.max_um_ = n_max;
  return table;
}

IndexTable IndexTable::from_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  if (!file || !(text << file.rdbuf())) {
    throw Error({path}, "cannot read the index table", "check the path");
  }
  return from_text(text.str(), path);
}

IndexTable IndexTable::embedded(std::string_view name) {
  for (const EmbeddedIndex& entry : embedded_indices()) {
    if (entry.name == name) return from_text(entry.text, std::string(name));
  }
  std::string list;
  for (const EmbeddedIndex& entry : embedded_indices()) {
    list += (list.empty() ? "" : ", ") + std::string(entry.name);
  }
  throw Error("no index table '" + std::string(name) + "'", "there are " + list);
}

std::vector<std::string> IndexTable::embedded_names() {
  std::vector<std::string> names;
  for (const EmbeddedIndex& entry : embedded_indices()) names.emplace_back(entry.name);
  return names;
}

void IndexTable::check_range(double wavelength_um) const {
  // NaN fails both comparisons and is refused too.
  if (wavelength_um >= min_um_ && wavelength_um <= max_um_) return;
  std::ostringstream problem, remedy;
  problem << wavelength_um << " um is outside the index data";
  remedy << "they cover " << min_um_ << " to " << max_um_ << " um";
  throw Error({origin_}, problem.str(), remedy.str());
}

double IndexTable::n(double wavelength_um) const {
  check_range(wavelength_um);
  return formula_ == 0 ? n_.at(wavelength_um) : dispersion(formula_, coefficients_, wavelength_um);
}

double IndexTable::kappa(double wavelength_um) const {
  check_range(wavelength_um);
  return kappa_.value.empty() ? 0.0 : kappa_.at(wavelength_um);
}

}  // namespace umov::optics
