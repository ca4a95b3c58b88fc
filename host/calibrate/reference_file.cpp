#include "host/calibrate/reference_file.hpp"

#include <cmath>
#include <cstdlib>
#include <map>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "host/errors/error.hpp"
#include "host/formats/atomic_file.hpp"
#include "host/formats/brdf_h5.hpp"
#include "host/formats/hdf5_image.hpp"
#include "host/formats/mueller_table.hpp"
#include "host/formats/nist_ptfe.hpp"
#include "host/formats/scan_table.hpp"

namespace umov::calibrate {

namespace {

std::vector<std::string> fields_of(std::string line) {
  if (!line.empty() && line.back() == '\r') line.pop_back();
  std::vector<std::string> fields;
  std::string field;
  std::istringstream in(line);
  while (std::getline(in, field, ',')) {
    const auto first = field.find_first_not_of(" \t");
    const auto last = field.find_last_not_of(" \t");
    fields.push_back(first == std::string::npos ? "" : field.substr(first, last - first + 1));
  }
  if (!line.empty() && line.back() == ',') fields.emplace_back();
  return fields;
}

/// One data line with access by column name.
class Row {
 public:
  Row(const std::map<std::string, std::size_t>& columns, std::vector<std::string> fields,
      std::string file, std::size_t line)
      : columns_(columns), fields_(std::move(fields)), file_(std::move(file)), line_(line) {}

  std::optional<std::string> text(const std::string& name) const {
    const auto found = columns_.find(name);
    if (found == columns_.end()) return std::nullopt;
    if (found->second >= fields_.size())
      throw Error(Place{file_, line_, name}, "the line ends before this column",
                  "every line has as many fields as the header");
    return fields_[found->second];
  }

  double number(const std::string& name) const {
    const std::string field = text(name).value_or("");
    char* end = nullptr;
    const double value = std::strtod(field.c_str(), &end);
    if (field.empty() || *end != '\0' || !std::isfinite(value))
      throw Error(Place{file_, line_, name}, fmt::format("`{}` is no number", field),
                  "write a finite decimal number");
    return value;
  }

  double axis(const std::string& name) const {
    const auto field = text(name);
    if (!field || *field == "open" || field->empty()) return formats::open_axis;
    return number(name);
  }

 private:
  const std::map<std::string, std::size_t>& columns_;
  std::vector<std::string> fields_;
  std::string file_;
  std::size_t line_;
};

std::string either(const std::map<std::string, std::size_t>& columns, const std::string& first,
                   const std::string& second) {
  return columns.contains(first) ? first : second;
}

formats::BrdfTable parse_csv(const std::string& text, const std::string& name) {
  formats::BrdfTable table;
  std::map<std::string, std::size_t> columns;
  std::istringstream in(text);
  std::string line;
  for (std::size_t number = 1; std::getline(in, line); ++number) {
    if (line.empty() || line == "\r" || line.front() == '#') continue;
    if (columns.empty()) {
      const auto header = fields_of(line);
      for (std::size_t c = 0; c < header.size(); ++c) columns[header[c]] = c;
      for (const char* needed : {"theta_i_deg", "theta_r_deg", "wavelength_nm"})
        if (!columns.contains(needed))
          throw Error(Place{name, number}, fmt::format("the column `{}` is missing", needed),
                      "name the columns theta_i_deg,theta_r_deg,wavelength_nm,brdf_per_sr in the "
                      "first line");
      if (!columns.contains("brdf_per_sr") && !columns.contains("value"))
        throw Error(Place{name, number}, "the column `brdf_per_sr` is missing",
                    "give the standard's BRDF in 1/sr");
      continue;
    }
    const Row row(columns, fields_of(line), name, number);
    if (row.text("quantity").value_or("brdf") != "brdf") continue;
    auto& p = table.points;
    p.theta_i_deg.push_back(row.number("theta_i_deg"));
    p.theta_r_deg.push_back(row.number("theta_r_deg"));
    p.phi_r_deg.push_back(columns.contains("phi_r_deg") ? row.number("phi_r_deg") : 0.0);
    p.wavelength_nm.push_back(row.number("wavelength_nm"));
    p.polarizer_deg.push_back(row.axis("polarizer_deg"));
    p.analyzer_deg.push_back(row.axis("analyzer_deg"));
    p.brdf_per_sr.push_back(row.number(either(columns, "brdf_per_sr", "value")));
    const std::string u = either(columns, "brdf_u", "uncertainty");
    p.brdf_u.push_back(columns.contains(u) ? row.number(u) : 0.0);
    p.used.push_back(columns.contains("used") && row.number("used") == 0.0 ? 0 : 1);
  }
  if (table.points.size() == 0)
    throw Error(Place{name}, "the standard's table has no point", "give at least one line of data");
  return table;
}

}  // namespace

formats::BrdfTable read_reference_table(const std::filesystem::path& path) {
  const std::string bytes = formats::read_whole_file(path);
  if (formats::looks_like_hdf5(bytes)) {
    formats::BrdfTable table = formats::read_brdf_h5(path).table;
    // Full matrices give every state, its points only the independent ones.
    if (table.mueller && table.mueller->side == 4)
      return formats::to_brdf_table(formats::mueller_table(table), formats::standard_states());
    return table;
  }
  if (bytes.starts_with("lambda,thetai")) {
    std::istringstream in(bytes);
    return formats::to_brdf_table(formats::read_nist_ptfe(in, path.string()),
                                  formats::standard_states());
  }
  return parse_csv(bytes, path.string());
}

}  // namespace umov::calibrate
