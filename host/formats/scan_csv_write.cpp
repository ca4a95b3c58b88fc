// Writing a Scan CSV from the columns alone.
#include <cmath>
#include <ostream>
#include <string>
#include <variant>

#include "host/errors/error.hpp"
#include "host/formats/atomic_file.hpp"
#include "host/formats/decimal.hpp"
#include "host/formats/scan_columns.hpp"
#include "host/formats/scan_csv.hpp"

namespace umov::formats {
namespace {

void append_canonical(std::string& out, Text text, double value) {
  switch (text) {
    case Text::seconds:
      append_fixed(out, value, 3);
      return;
    case Text::signal:
      append_general(out, value, 8);
      return;
    case Text::standard_error:
      append_general(out, value, 4);
      return;
    case Text::monitor:
      append_general(out, value, 7);
      return;
    case Text::range:
      if (std::abs(value) < 1e15 && value == std::floor(value)) {
        append_integer(out, static_cast<std::int64_t>(value));
        return;
      }
      append_general(out, value, 6);
      return;
    case Text::angle:
    case Text::axis:
    case Text::integer:
    case Text::shutter:
      append_general(out, value, 6);
      return;
  }
}

void append_value(std::string& out, const ScanColumn& column, double value) {
  if (column.text == Text::axis && is_open(value)) {
    out += "open";
    return;
  }
  const std::size_t start = out.size();
  append_canonical(out, column.text, value);
  double back = 0;
  if (read_decimal(std::string_view(out).substr(start), back) == nullptr && back == value) return;
  out.resize(start);
  append_shortest(out, value);
}

void append_value(std::string& out, const ScanColumn& column, std::int64_t value) {
  if (column.text == Text::shutter) {
    out += value != 0 ? "open" : "closed";
  } else {
    append_integer(out, value);
  }
}

void append_value(std::string& out, const ScanColumn& column, int value) {
  append_value(out, column, static_cast<std::int64_t>(value));
}

}  // namespace

std::string scan_csv_text(const ScanTable& table) {
  validate(table, "scan");
  std::string out;
  out.reserve(1024 + table.size() * 128);
  for (const auto& [key, value] : table.keys)
    out += value.empty() ? "# " + key + ":\n" : "# " + key + ": " + value + "\n";
  for (const Block& block : table.blocks) {
    out += "# block: " + block.name + " " + std::to_string(block.first) + "-" +
           std::to_string(block.last);
    for (const auto& [key, value] : block.settings) out += " " + key + "=" + value;
    out += "\n";
  }
  for (const ScanColumn& column : scan_columns) {
    if (&column != &scan_columns.front()) out += ",";
    out += column.name;
  }
  out += "\n";
  for (std::size_t row = 0; row < table.size(); ++row) {
    for (const ScanColumn& column : scan_columns) {
      if (&column != &scan_columns.front()) out += ',';
      std::visit([&](auto member) { append_value(out, column, (table.*member)[row]); },
                 column.data);
    }
    out += '\n';
  }
  return out;
}

void write_scan_csv(const ScanTable& table, std::ostream& out) {
  const std::string text = scan_csv_text(table);
  out.write(text.data(), static_cast<std::streamsize>(text.size()));
  if (!out) throw Error("the scan could not be written to the stream", "check the destination");
}

void write_scan_csv(const ScanTable& table, const std::filesystem::path& path) {
  replace_file(path, scan_csv_text(table));
}

void round_to_canonical(ScanTable& table) {
  std::string text;
  for (const ScanColumn& column : scan_columns) {
    const auto* member = std::get_if<std::vector<double> ScanTable::*>(&column.data);
    if (member == nullptr) continue;
    for (double& value : table.*(*member)) {
      if (!std::isfinite(value)) continue;
      text.clear();
      append_canonical(text, column.text, value);
      double rounded = value;
      read_decimal(text, rounded);
      value = rounded + 0.0;  // no negative zero in files
    }
  }
}

}  // namespace umov::formats
