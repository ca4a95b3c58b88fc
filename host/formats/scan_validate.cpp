// The rules every scan obeys, wherever it comes from.
#include <cmath>
#include <string>
#include <variant>

#include "host/errors/error.hpp"
#include "host/formats/decimal.hpp"
#include "host/formats/scan_columns.hpp"
#include "host/formats/scan_csv.hpp"
#include "host/formats/scan_rules.hpp"

namespace umov::formats {

std::string column_range_text(const ScanColumn& column) {
  if (column.text == Text::shutter) return "`open` or `closed`";
  if (column.name == "direction") return "1 or -1";
  if (column.name == "phi_r_deg") return "above -180, up to 180 deg";
  if (column.text == Text::axis) return "degrees from p towards +s, -360 to 360, or `open`";
  if (column.text == Text::range) return "a positive amplifier range such as 1, 10, 100, 1000";
  if (column.name == "wavelength_nm")
    return "nanometres from 100 to 100000; 0.532 would be micrometres";
  if (column.name == "index") return "integers from 0 upwards";
  std::string unit = column.unit == "1" ? "" : " " + std::string(column.unit);
  if (column.lowest == -unlimited && column.highest == unlimited)
    return "a finite number" + (unit.empty() ? std::string() : " in" + unit);
  if (column.highest == unlimited) return decimal_text(column.lowest) + unit + " or more";
  return decimal_text(column.lowest) + " to " + decimal_text(column.highest) + unit;
}

bool within_column(const ScanColumn& column, double value) {
  if (column.text == Text::axis && is_open(value)) return true;
  // Written so that NaN is outside.
  if (!(value >= column.lowest && value <= column.highest)) return false;
  if (column.name == "direction") return value == 1 || value == -1;
  if (column.name == "phi_r_deg") return value > -180;
  return true;
}

bool is_numeric_key(std::string_view key) {
  return key == "solid_angle_sr" || key.starts_with("gain_constant_") || key == "adc_step_v" ||
         key == "adc_full_scale_v" || key.starts_with("reference_dhr_");
}

bool is_contract_key(std::string_view key) {
  return is_numeric_key(key) || key == "format" || key == "sample" || key == "device" ||
         key == "role" || key == "reference" || key == "reference_brdf";
}

std::string key_problem(const std::string& key, const std::string& value) {
  if (key == "format" && value != "umov scan csv")
    return "the format is \"" + value + "\", not \"umov scan csv\"";
  if (key == "role" && value != "sample" && value != "white" && value != "mirror" &&
      value != "dark")
    return "the role \"" + value + "\" is none of sample, white, mirror, dark";
  if (!is_numeric_key(key)) return {};
  double number = 0;
  if (const char* problem = read_decimal(value, number))
    return "the header key `" + key + "` has the value \"" + value + "\": " + problem;
  if (number < 0 || (number == 0 && !key.ends_with("_u")))
    return "the header key `" + key + "` has the value \"" + value + "\": must be above 0";
  return {};
}

std::string block_problem(const Block& block, const std::vector<std::int64_t>& index) {
  if (block.name.empty() || block.name.find_first_of(" \t=") != std::string::npos)
    return "the block name \"" + block.name + "\" is not one word";
  if (block.first < 0 || block.last < block.first)
    return "block `" + block.name + "` has the range " + std::to_string(block.first) + "-" +
           std::to_string(block.last);
  if (index.empty() || block.first < index.front() || block.last > index.back())
    return "block `" + block.name + "` names rows " + std::to_string(block.first) + "-" +
           std::to_string(block.last) + ", but the file has rows " +
           (index.empty() ? "none"
                          : std::to_string(index.front()) + "-" + std::to_string(index.back()));
  return {};
}

void validate(const ScanTable& table, const std::string& name) {
  const auto fail = [&](std::string_view column, const std::string& problem,
                        const std::string& remedy) {
    throw Error(Place{name, 0, std::string(column)}, problem, remedy);
  };
  const std::size_t n = table.size();
  for (const ScanColumn& column : scan_columns) {
    std::visit(
        [&](auto member) {
          const auto& values = table.*member;
          if (values.size() != n)
            fail(column.name,
                 "has " + std::to_string(values.size()) + " entries, `index` has " +
                     std::to_string(n),
                 "all columns of a scan have one entry a record");
          for (std::size_t row = 0; row < n; ++row)
            if (const double value = static_cast<double>(values[row]);
                !within_column(column, value))
              fail(column.name, "record " + std::to_string(row) + " holds " + decimal_text(value),
                   "permitted: " + column_range_text(column));
        },
        column.data);
  }
  for (std::size_t row = 0; row < n; ++row) {
    if (row > 0 && table.index[row] <= table.index[row - 1])
      fail("index",
           "record " + std::to_string(row) + " has index " + std::to_string(table.index[row]) +
               " after " + std::to_string(table.index[row - 1]),
           "the index grows from record to record");
    if (table.phi_r_deg[row] != 0 && table.theta_r_deg[row] < 0)
      fail("theta_r_deg",
           "record " + std::to_string(row) + " has theta_r_deg < 0 with phi_r_deg not 0",
           out_of_plane_remedy);
  }
  for (const auto& [key, value] : table.keys) {
    if (key.empty() || key == "block" || key.find(':') != std::string::npos)
      fail("", "\"" + key + "\" cannot be a header key", "choose a name without colons");
    for (const char c : key + value)
      if (static_cast<unsigned char>(c) < 32 && c != '\t')
        fail("", "the header key `" + key + "` holds a control character",
             "keys and values are one line of plain text");
    if (const std::string problem = key_problem(key, value); !problem.empty())
      fail("", problem, "correct the header key");
  }
  for (const Block& block : table.blocks) {
    if (const std::string problem = block_problem(block, table.index); !problem.empty())
      fail("", problem, "blocks are `NAME FIRST-LAST key=value …` within the rows");
    for (const auto& [key, value] : block.settings)
      if (key.empty() || (key + value).find_first_of(" \t\r\n") != std::string::npos ||
          key.find('=') != std::string::npos)
        fail("", "block `" + block.name + "` has the setting `" + key + "=" + value + "`",
             "settings are key=value without blanks");
  }
}

}  // namespace umov::formats
