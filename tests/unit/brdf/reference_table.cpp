#include "tests/unit/brdf/reference_table.hpp"

#include <fstream>
#include <stdexcept>

namespace umov::brdf::reference {
namespace {

std::vector<std::string> fields(const std::string& line) {
  std::vector<std::string> out(1);
  bool quoted = false;
  for (const char c : line) {
    if (c == '"') {
      quoted = !quoted;
    } else if (c == ',' && !quoted) {
      out.emplace_back();
    } else {
      out.back() += c;
    }
  }
  return out;
}

double or_zero(const std::string& text) {
  return text.empty() ? 0.0 : std::stod(text);
}

}  // namespace

double Row::number(const std::string& key) const {
  const auto found = parameters.find(key);
  if (found == parameters.end()) throw std::runtime_error("row " + id + " has no " + key);
  return std::stod(found->second);
}

std::pair<double, double> Row::substrate() const {
  const std::string& text = parameters.at("substrate");
  const auto comma = text.find(',');
  return {std::stod(text.substr(1)), std::stod(text.substr(comma + 1))};
}

std::vector<Row> read() {
  std::ifstream file(UMOV_TEST_DATA "/reference/brdf_reference_values.csv");
  std::vector<Row> rows;
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line[0] == '#' || line.starts_with("id,")) continue;
    const std::vector<std::string> f = fields(line);
    if (f.size() < 25) throw std::runtime_error("short reference row: " + line);
    Row row{f[0], f[1], f[2], f[7], {}, or_zero(f[4]), or_zero(f[5]), or_zero(f[6]), {}, {}};
    for (std::size_t at = 0; at < f[3].size();) {
      std::size_t end = f[3].find(';', at);
      if (end == std::string::npos) end = f[3].size();
      std::string entry = f[3].substr(at, end - at);
      while (!entry.empty() && entry[0] == ' ') entry.erase(0, 1);
      const auto equals = entry.find('=');
      row.parameters[entry.substr(0, equals)] = entry.substr(equals + 1);
      at = end + 1;
    }
    if (!f[8].empty()) {
      std::array<double, 16> m{};
      for (std::size_t i = 0; i < 16; ++i) m[i] = std::stod(f[8 + i]);
      row.mueller = m;
    }
    if (!f[24].empty()) row.value = std::stod(f[24]);
    rows.push_back(row);
  }
  if (rows.empty()) throw std::runtime_error("no reference values found");
  return rows;
}

}  // namespace umov::brdf::reference
