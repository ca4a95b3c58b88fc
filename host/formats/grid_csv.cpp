#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include <fmt/format.h>

#include "host/brdf/grid_table.hpp"
#include "host/errors/error.hpp"
#include "host/formats/number_csv.hpp"
#include "host/formats/table_csv.hpp"
#include "host/formats/table_csv_rows.hpp"
#include "host/optics/angles.hpp"

namespace umov::formats {
namespace {

constexpr std::array<std::string_view, 20> columns{
    "theta_i_deg", "theta_r_deg", "phi_r_deg", "wavelength_nm", "m00", "m01", "m02",
    "m03",         "m10",         "m11",       "m12",           "m13", "m20", "m21",
    "m22",         "m23",         "m30",       "m31",           "m32", "m33"};
constexpr std::string_view start = "theta_i_deg,theta_r_deg,phi_r_deg,wavelength_nm,m00";
constexpr std::size_t directions = 4;

/// Elements between {I, Q} and {U, V}: odd in the azimuth on a surface with mirror symmetry.
constexpr std::array<int, 8> odd_elements{2, 3, 6, 7, 8, 9, 12, 13};
constexpr double odd_tolerance = 0.05;
constexpr double element_tolerance = 1.1;  ///< of m00; measured elements have noise

struct Row {
  std::array<double, directions> at;  ///< θi, θr, φ, wavelength in the columns' units
  std::array<double, 16> elements;
  std::size_t line;
};

std::vector<Row> read_rows(std::string_view bytes, const std::string& file, std::size_t elements) {
  std::vector<Row> rows;
  const auto known = std::span(columns).first(directions + elements);
  read_number_csv(
      bytes, file, known, 0,
      [&](std::span<const std::string_view>, std::span<const double> numbers, std::size_t line) {
        Row row{{}, {}, line};
        std::copy_n(numbers.begin(), directions, row.at.begin());
        std::copy_n(numbers.begin() + directions, elements, row.elements.begin());
        require_range(file, line, columns[0], row.at[0], 0, 89.999);
        require_range(file, line, columns[1], row.at[1], -90, 90);
        require_range(file, line, columns[2], row.at[2], -180, 180);
        require_range(file, line, columns[3], row.at[3], 1, 1e6);
        require_range(file, line, columns[4], row.elements[0], 0, 1e9);
        const double most = element_tolerance * row.elements[0];
        for (std::size_t e = 1; e < elements; ++e)
          require_range(file, line, columns[directions + e], row.elements[e], -most, most);
        // In plane the exit angle may be signed; both names mean one direction.
        if (row.at[1] < 0) {
          if (row.at[2] != 0)
            throw Error(Place{file, line, "theta_r_deg"},
                        "is negative out of the plane of incidence",
                        "only with phi_r_deg 0 does the sign mean the retro side");
          row.at[1] = -row.at[1];
          row.at[2] = 180;
        }
        row.at[1] += 0.0;  // no negative zero
        rows.push_back(row);
      });
  return rows;
}

void require_mirror_symmetry(const Row& row, const std::string& file) {
  if (row.at[2] != 0 && row.at[2] != 180) return;
  for (const int e : odd_elements) {
    const auto element = static_cast<std::size_t>(e);
    if (std::abs(row.elements[element]) > odd_tolerance * row.elements[0])
      throw Error(Place{file, row.line, std::string(columns[directions + element])},
                  "does not vanish in the plane of incidence",
                  "a half circle of azimuths is for mirror-symmetric surfaces in the bases {s, p}; "
                  "give the full circle, or turn the bases");
  }
}

std::vector<double> sampled_incidences_deg() {
  std::vector<double> list;
  for (int n = 0; n <= 17; ++n) list.push_back(5.0 * n);
  return list;
}

std::vector<double> sampled_exits_deg() {
  std::vector<double> list;
  for (int n = 0; n <= 35; ++n) list.push_back(2.5 * n);
  return list;
}

std::vector<double> sampled_azimuths_deg() {
  std::vector<double> list{0, 1, 2, 3, 4, 5, 7.5, 10, 12.5, 15};
  for (int n = 4; n <= 36; ++n) list.push_back(5.0 * n);
  return list;
}

/// Where a table's own wavelengths hold `um`.
std::optional<std::size_t> stored(const brdf::GridTable& grid, double um) {
  const auto& axis = grid.axes().wavelength_um;
  for (std::size_t w = 0; w < axis.size(); ++w)
    if (axis[w] == um) return w;
  return std::nullopt;
}

}  // namespace

bool is_grid_csv(std::string_view bytes) {
  return csv_header_line(bytes.substr(0, 65536)).starts_with(start);
}

TablePtr read_grid_csv(std::string_view bytes, const std::string& file) {
  const std::string_view header = csv_header_line(bytes);
  const std::size_t elements = header.find("m01") == std::string_view::npos ? 1 : 16;
  const std::vector<Row> rows = read_rows(bytes, file, elements);

  std::array<std::vector<double>, directions> axes;
  for (std::size_t d = 0; d < directions; ++d) {
    for (const Row& row : rows) axes[d].push_back(row.at[d]);
    axes[d] = distinct(std::move(axes[d]));
  }
  // Each factor is at most the number of rows, which is at most the size of the file.
  const double cells = static_cast<double>(axes[0].size()) * static_cast<double>(axes[1].size()) *
                       static_cast<double>(axes[2].size()) * static_cast<double>(axes[3].size());
  if (cells > static_cast<double>(rows.size()))
    throw Error(
        Place{file},
        fmt::format("{} rows do not fill the grid of {} x {} x {} x {} directions and wavelengths",
                    rows.size(), axes[0].size(), axes[1].size(), axes[2].size(), axes[3].size()),
        "give every exit angle and azimuth for every incidence and wavelength, or import the "
        "file as measured points");
  const bool half_circle = axes[2].front() >= 0;
  const auto count = static_cast<std::size_t>(cells);
  std::vector<double> values(count * elements, std::numeric_limits<double>::quiet_NaN());
  for (const Row& row : rows) {
    if (half_circle && elements == 16) require_mirror_symmetry(row, file);
    std::array<std::size_t, directions> p{};
    for (std::size_t d = 0; d < directions; ++d) p[d] = position(axes[d], row.at[d]);
    const std::size_t cell =
        ((p[3] * axes[0].size() + p[0]) * axes[1].size() + p[1]) * axes[2].size() + p[2];
    if (!std::isnan(values[cell * elements]))
      throw Error(Place{file, row.line}, "a direction is given twice", "keep one row");
    for (std::size_t e = 0; e < elements; ++e) values[cell * elements + e] = row.elements[e];
  }
  // As many rows as cells and none twice: the grid is full.
  brdf::GridAxes grid{axes[0], axes[1], axes[2], axes[3]};
  for (double& wavelength : grid.wavelength_um) wavelength = micrometres(wavelength);
  return std::make_shared<brdf::GridTable>(std::move(grid), std::move(values),
                                           static_cast<int>(elements), file);
}

std::string write_grid_csv(const brdf::Table& table, const TableWriting& writing) {
  const auto* grid = dynamic_cast<const brdf::GridTable*>(&table);
  const std::vector<double> wavelengths_um = written_wavelengths(table, writing);
  const auto incidences = grid ? grid->axes().theta_i_deg : sampled_incidences_deg();
  const auto exits = grid ? grid->axes().theta_r_deg : sampled_exits_deg();
  const auto azimuths = grid ? grid->axes().phi_r_deg : sampled_azimuths_deg();
  const std::size_t elements = table.polarised() ? 16 : 1;

  std::string out = "# format: umov table csv\n";
  TableHeader header = table_header(table, writing, wavelengths_um, table.polarised());
  if (!grid) header.notes.push_back("sampled on a grid; lobes narrower than its steps are lost");
  for (const std::string& line : header.lines()) out += "# " + line + "\n";
  for (std::size_t c = 0; c < directions + elements; ++c)
    out += (c > 0 ? "," : "") + std::string(columns[c]);
  out += '\n';
  std::array<double, directions + 16> row{};
  double done = 0;
  for (const double um : wavelengths_um) {
    row[3] = nanometres(um);
    const auto own = grid ? stored(*grid, um) : std::nullopt;
    for (std::size_t i = 0; i < incidences.size(); ++i) {
      for (std::size_t r = 0; r < exits.size(); ++r)
        for (std::size_t p = 0; p < azimuths.size(); ++p) {
          row[0] = incidences[i];
          row[1] = exits[r];
          row[2] = azimuths[p];
          if (own) {
            const std::size_t cell =
                ((*own * incidences.size() + i) * exits.size() + r) * azimuths.size() + p;
            for (std::size_t e = 0; e < elements; ++e)
              row[directions + e] = grid->values()[cell * elements + e];
          } else {
            const auto m = table.at(
                um, {optics::radians(row[0]), optics::radians(row[1]), optics::radians(row[2])});
            for (std::size_t e = 0; e < elements; ++e)
              row[directions + e] =
                  optics::element(m, static_cast<int>(e / 4), static_cast<int>(e % 4));
          }
          append_row(out, std::span(row).first(directions + elements));
        }
      done += 1;
      if (writing.progress)
        writing.progress(done, static_cast<double>(incidences.size() * wavelengths_um.size()));
    }
  }
  return out;
}

}  // namespace umov::formats
