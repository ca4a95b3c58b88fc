#include "host/formats/table_csv_rows.hpp"

#include <algorithm>
#include <cmath>

#include "host/errors/error.hpp"
#include "host/formats/decimal.hpp"

namespace umov::formats {

void require_range(const std::string& file, std::size_t line, std::string_view column, double value,
                   double low, double high) {
  if (value >= low && value <= high) return;
  throw Error(Place{file, line, std::string(column)}, decimal_text(value) + " is out of range",
              "values lie from " + decimal_text(low) + " to " + decimal_text(high));
}

double micrometres(double wavelength_nm) {
  return std::round(wavelength_nm * 1e9) / 1e12;
}

double nanometres(double wavelength_um) {
  return std::round(wavelength_um * 1e12) / 1e9;
}

std::vector<double> distinct(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
  return values;
}

std::size_t position(std::span<const double> axis, double value) {
  return static_cast<std::size_t>(std::lower_bound(axis.begin(), axis.end(), value) - axis.begin());
}

void append_row(std::string& out, std::span<const double> numbers) {
  const char* separator = "";
  for (const double number : numbers) {
    out += separator + decimal_text(number);
    separator = ",";
  }
  out += '\n';
}

}  // namespace umov::formats
