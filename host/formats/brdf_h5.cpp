#include "host/formats/brdf_h5.hpp"

#include <array>
#include <cmath>
#include <string>

#include "host/errors/error.hpp"
#include "host/formats/atomic_file.hpp"
#include "host/formats/brdf_columns.hpp"
#include "host/formats/content_hash.hpp"
#include "host/formats/h5_header.hpp"
#include "host/formats/hdf5_image.hpp"
#include "host/formats/mueller_columns.hpp"
#include "host/formats/scan_table.hpp"

namespace umov::formats {
namespace {

constexpr const char* format_name = "umov brdf h5";

void check_table(const BrdfTable& table, const std::string& name) {
  const auto fail = [&](const std::string& column, const std::string& problem) {
    throw Error(Place{name, 0, column}, problem,
                "columns of a group have one finite number an entry");
  };
  for_each_brdf_column(table, [&](const BrdfColumn& column, const auto& values, std::size_t n) {
    const std::string path = column.path();
    if (values.size() != n)
      fail(path, "has " + std::to_string(values.size()) + " entries, not " + std::to_string(n));
    for (std::size_t i = 0; i < n; ++i) {
      const double value = static_cast<double>(values[i]);
      if (!std::isfinite(value) && !(column.axis && std::isnan(value)))
        fail(path, "entry " + std::to_string(i) + " is not a finite number");
    }
  });
  for (const BrdfTable::Factor& factor : table.factors) {
    if (factor.per_point.size() != table.points.size())
      fail("/covariance", "factor `" + factor.name + "` has " +
                              std::to_string(factor.per_point.size()) + " entries, not " +
                              std::to_string(table.points.size()));
    for (const double value : factor.per_point)
      if (!std::isfinite(value)) fail("/covariance", "factor `" + factor.name + "` is not finite");
  }
  if (table.mueller) check_mueller(*table.mueller, name);
}

}  // namespace

std::string content_sha256(const BrdfTable& table) {
  ContentHash hash;
  hash.text(format_name);
  hash.pairs("header", table.keys);
  for_each_brdf_column(table, [&](const BrdfColumn& column, const auto& values, std::size_t) {
    using Value = typename std::remove_cvref_t<decltype(values)>::value_type;
    hash.column(column.path(), std::span<const Value>(values));
  });
  for (const BrdfTable::Factor& factor : table.factors) hash.column(factor.name, factor.per_point);
  if (table.mueller)
    for_each_mueller_column(*table.mueller, [&](const MuellerColumn& column, const auto& values) {
      hash.column(column.path(), values);
    });
  return hash.hex_digest();
}

void write_brdf_h5(const std::filesystem::path& path, const BrdfTable& table,
                   const Provenance& provenance, const std::function<void(Hdf5Builder&)>& more) {
  check_table(table, path.string());
  check_storable(table.keys, path.string());
  Hdf5Builder file(path.string());
  write_h5_header(file, format_name, table.keys, provenance, content_sha256(table));
  for (const char* group : {"/points", "/dolp", "/dhr"}) file.group(group);
  for_each_brdf_column(table, [&](const BrdfColumn& column, const auto& values, std::size_t) {
    using Values = std::remove_cvref_t<decltype(values)>;
    if constexpr (std::is_same_v<Values, std::vector<int>>) {
      file.small_column(column.path(), values, column.unit);
    } else {
      file.column(column.path(), values, column.unit);
    }
    if (column.axis) file.attribute(column.path(), "open", "NaN");
  });
  if (!table.factors.empty()) {
    std::vector<std::string> names;
    std::vector<double> rows;
    for (const BrdfTable::Factor& factor : table.factors) {
      names.push_back(factor.name);
      rows.insert(rows.end(), factor.per_point.begin(), factor.per_point.end());
    }
    file.group("/covariance");
    file.column("/covariance/name", names);
    file.matrix("/covariance/per_point", rows, names.size(), table.points.size(), "1/sr");
    file.attribute("/covariance", "meaning",
                   "cov = diag(brdf_u^2) + sum over rows F of outer(F, F)");
  }
  if (table.mueller) write_mueller(file, *table.mueller);
  if (more) more(file);
  replace_file(path, file.finish());
}

BrdfFile read_brdf_h5(const std::filesystem::path& path) {
  const std::string name = path.string();
  const Hdf5Reader file(read_whole_file(path), name);
  BrdfFile brdf;
  brdf.provenance = read_h5_header(file, format_name, brdf.table.keys);
  for_each_brdf_column(brdf.table, [&](const BrdfColumn& column, auto& values, std::size_t) {
    using Values = std::remove_cvref_t<decltype(values)>;
    // A file of another program may leave DOLP and DHR out.
    if (!file.has(column.path()) && std::string_view(column.group) != "points") return;
    if constexpr (std::is_same_v<Values, std::vector<int>>) {
      values = file.small_integers(column.path());
    } else {
      values = file.doubles(column.path());
    }
  });
  if (file.has("/covariance")) {
    const std::vector<std::string> names = file.texts("/covariance/name");
    std::size_t rows = 0, columns = 0;
    const std::vector<double> values = file.matrix("/covariance/per_point", rows, columns);
    if (rows != names.size()) file.fail("/covariance", "names and rows differ in number");
    for (std::size_t row = 0; row < rows; ++row) {
      const auto start = values.begin() + static_cast<std::ptrdiff_t>(row * columns);
      brdf.table.factors.push_back(
          {names[row], {start, start + static_cast<std::ptrdiff_t>(columns)}});
    }
  }
  brdf.table.mueller = read_mueller(file);
  check_table(brdf.table, name);
  brdf.content_sha256 = content_sha256(brdf.table);
  verify_h5_content(file, brdf.content_sha256);
  return brdf;
}

}  // namespace umov::formats
