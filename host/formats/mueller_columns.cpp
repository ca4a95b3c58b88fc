#include "host/formats/mueller_columns.hpp"

#include <cmath>
#include <utility>

#include "host/errors/error.hpp"
#include "host/formats/decimal.hpp"
#include "host/formats/hdf5_image.hpp"

namespace umov::formats {

namespace {

constexpr const char* group = "/mueller";

std::size_t width(const BrdfTable::Mueller& m, MuellerColumn::Shape shape) {
  switch (shape) {
    case MuellerColumn::Shape::elements:
      return m.elements();
    case MuellerColumn::Shape::packed:
      return m.packed();
    case MuellerColumn::Shape::one:
      break;
  }
  return 1;
}

std::string cell(double value) {
  return std::isnan(value) ? std::string() : decimal_text(value);
}

}  // namespace

std::size_t BrdfTable::Mueller::covariance_at(std::size_t n, std::size_t row,
                                              std::size_t column) const {
  if (row > column) std::swap(row, column);
  return n * packed() + row * elements() - row * (row + 1) / 2 + column;
}

void check_mueller(const BrdfTable::Mueller& mueller, const std::string& name) {
  const auto fail = [&](const std::string& column, const std::string& problem) {
    throw Error(Place{name, 0, column}, problem, "write the file anew from its source");
  };
  if (mueller.side != 3 && mueller.side != 4) fail(group, "is neither 3 x 3 nor 4 x 4");
  for_each_mueller_column(mueller, [&](const MuellerColumn& column, const auto& values) {
    if (column.shape == MuellerColumn::Shape::packed && values.empty()) return;
    const std::size_t wanted = mueller.size() * width(mueller, column.shape);
    if (values.size() != wanted)
      fail(column.path(),
           "has " + std::to_string(values.size()) + " entries, not " + std::to_string(wanted));
    for (std::size_t i = 0; i < values.size(); ++i)
      if (!std::isfinite(values[i]) && !(column.gaps && std::isnan(values[i])))
        fail(column.path(), "entry " + std::to_string(i) + " is not a finite number");
  });
}

void write_mueller(Hdf5Builder& file, const BrdfTable::Mueller& mueller) {
  file.group(group);
  for_each_mueller_column(mueller, [&](const MuellerColumn& column, const auto& values) {
    if (column.shape == MuellerColumn::Shape::one)
      file.column(column.path(), values, column.unit);
    else if (!values.empty())
      file.matrix(column.path(), values, mueller.size(), width(mueller, column.shape), column.unit);
    else
      return;
    if (column.gaps) file.attribute(column.path(), "undetermined", "NaN");
  });
  file.attribute(group, "meaning",
                 "Mueller BRDF row by row in the order I, Q, U (V), frames {s, p} with Q > 0 for s "
                 "and U > 0 for s + p");
}

std::optional<BrdfTable::Mueller> read_mueller(const Hdf5Reader& file) {
  if (!file.has(group)) return std::nullopt;
  BrdfTable::Mueller mueller;
  for_each_mueller_column(mueller, [&](const MuellerColumn& column, auto& values) {
    if (column.shape == MuellerColumn::Shape::one) {
      values = file.doubles(column.path());
      return;
    }
    if (column.shape == MuellerColumn::Shape::packed && !file.has(column.path())) return;
    std::size_t rows = 0, columns = 0;
    values = file.matrix(column.path(), rows, columns);
    if (std::string_view(column.name) == "mueller") {
      if (columns != 9 && columns != 16)
        file.fail(column.path(), "has " + std::to_string(columns) + " columns, not 9 or 16");
      mueller.side = columns == 9 ? 3 : 4;
    }
    if (rows != mueller.size() || columns != width(mueller, column.shape))
      file.fail(column.path(), "is " + std::to_string(rows) + " x " + std::to_string(columns));
  });
  return mueller;
}

std::string mueller_csv_text(const BrdfTable& table) {
  if (!table.mueller)
    throw Error("the file has no Mueller elements",
                "reduce a scan with P, S and +-45 deg states, or import a Mueller table");
  const BrdfTable::Mueller& m = *table.mueller;
  std::string out = "# format: umov mueller csv\n";
  for (const auto& [key, value] : table.keys)
    if (key != "format") out += "# " + key + ": " + value + "\n";
  out +=
      "# mRC: element (out, in) in the order I Q U V, 1/sr; Q > 0 is s, U > 0 is s + p; phi_r 0 is "
      "the specular half plane; mRC_u: one sigma\n"
      "theta_i_deg,theta_r_deg,phi_r_deg,wavelength_nm";
  const auto names = [&](const char* ending) {
    for (int row = 0; row < m.side; ++row)
      for (int column = 0; column < m.side; ++column)
        out += ",m" + std::to_string(row) + std::to_string(column) + ending;
  };
  names("");
  names("_u");
  out += ",condition,chi2,degrees_of_freedom,realisable_z\n";
  for (std::size_t n = 0; n < m.size(); ++n) {
    out += decimal_text(m.theta_i_deg[n]) + "," + decimal_text(m.theta_r_deg[n]) + "," +
           decimal_text(m.phi_r_deg[n]) + "," + decimal_text(m.wavelength_nm[n]);
    for (const std::vector<double>* values : {&m.mueller, &m.mueller_u})
      for (std::size_t k = 0; k < m.elements(); ++k)
        out += "," + cell((*values)[n * m.elements() + k]);
    out += "," + cell(m.condition[n]) + "," + cell(m.chi2[n]) + "," + cell(m.dof[n]) + "," +
           cell(m.realisable_z[n]) + "\n";
  }
  return out;
}

}  // namespace umov::formats
