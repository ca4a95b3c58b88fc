#include "host/formats/scan_table.hpp"

#include <cmath>
#include <limits>
#include <variant>

#include "host/errors/error.hpp"
#include "host/formats/decimal.hpp"
#include "host/formats/scan_columns.hpp"

namespace umov::formats {

const double open_axis = std::numeric_limits<double>::quiet_NaN();

bool is_open(double axis_deg) {
  return std::isnan(axis_deg);
}

void ScanTable::reserve(std::size_t n) {
  for (const ScanColumn& column : scan_columns)
    std::visit([&](auto member) { (this->*member).reserve(n); }, column.data);
}

std::optional<std::string> ScanTable::key(const std::string& name) const {
  for (const auto& [key, value] : keys)
    if (key == name) return value;
  return std::nullopt;
}

std::optional<double> ScanTable::number(const std::string& name) const {
  const std::optional<std::string> text = key(name);
  if (!text) return std::nullopt;
  double value = 0;
  if (const char* problem = read_decimal(*text, value))
    throw Error("the header key `" + name + "` has the value \"" + *text + "\": " + problem,
                "give a plain decimal number such as 1e-4");
  return value;
}

void ScanTable::set_key(const std::string& name, const std::string& value) {
  for (auto& [key, old] : keys)
    if (key == name) {
      old = value;
      return;
    }
  keys.emplace_back(name, value);
}

}  // namespace umov::formats
