#include "hil/plant/table_sample.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <fstream>
#include <sstream>
#include <utility>

#include "host/errors/error.hpp"

namespace umov::plant {
namespace {

constexpr std::array<const char*, 4> coordinate_names = {"theta_i_deg", "theta_r_deg", "phi_r_deg",
                                                         "wavelength_nm"};

struct Row {
  std::array<double, 4> coordinate;
  Mueller value;
  std::size_t line;
};

std::vector<std::string_view> split(std::string_view line) {
  std::vector<std::string_view> cells;
  while (true) {
    const std::size_t comma = line.find(',');
    std::string_view cell = line.substr(0, comma);
    while (!cell.empty() && (cell.front() == ' ' || cell.front() == '\t')) cell.remove_prefix(1);
    while (!cell.empty() && (cell.back() == ' ' || cell.back() == '\t')) cell.remove_suffix(1);
    cells.push_back(cell);
    if (comma == std::string_view::npos) return cells;
    line.remove_prefix(comma + 1);
  }
}

std::vector<std::string> expected_header(bool scalar) {
  std::vector<std::string> names(coordinate_names.begin(), coordinate_names.end());
  if (scalar) {
    names.emplace_back("brdf");
    return names;
  }
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) {
      names.push_back("m" + std::to_string(row) + std::to_string(column));
    }
  }
  return names;
}

double number(std::string_view cell, const Place& place) {
  double value = 0.0;
  const auto [end, code] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (code != std::errc() || end != cell.data() + cell.size() || !std::isfinite(value)) {
    throw Error(place, "\"" + std::string(cell) + "\" is not a number",
                "write a finite decimal number");
  }
  return value;
}

/// U and V change sign when a mirror turns φ into -φ.
Mueller mirrored(Mueller m) {
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) {
      if ((row < 2) != (column < 2)) {
        optics::set_element(m, row, column, -optics::element(m, row, column));
      }
    }
  }
  return m;
}

/// Brings a row to θr >= 0 and 0 <= φ <= 180.
void canonicalize(Row& row) {
  double& theta_r = row.coordinate[1];
  double& phi = row.coordinate[2];
  if (theta_r < 0.0) {
    theta_r = -theta_r;
    phi += 180.0;
  }
  phi = std::remainder(phi, 360.0);
  if (phi < 0.0) {
    if (phi > -180.0) row.value = mirrored(row.value);
    phi = -phi;
  }
}

std::vector<Row> read_rows(std::string_view text, const std::string& origin) {
  std::vector<Row> rows;
  std::vector<std::string> header;
  std::size_t line_number = 0;
  while (!text.empty()) {
    ++line_number;
    const std::size_t end = text.find('\n');
    std::string_view line = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    if (line.empty() || line.front() == '#') continue;
    const auto cells = split(line);
    if (header.empty()) {
      header = expected_header(cells.size() <= 5);
      for (std::size_t i = 0; i < header.size(); ++i) {
        if (i >= cells.size() || cells[i] != header[i]) {
          throw Error({origin, line_number, header[i]}, "column \"" + header[i] + "\" is missing",
                      "the header is theta_i_deg,theta_r_deg,phi_r_deg,wavelength_nm and then "
                      "brdf or m00,m01,…,m33");
        }
      }
      if (cells.size() > header.size()) {
        throw Error({origin, line_number, std::string(cells[header.size()])}, "unknown column",
                    "remove it");
      }
      continue;
    }
    if (cells.size() != header.size()) {
      throw Error({origin, line_number},
                  "the row has " + std::to_string(cells.size()) + " columns, the header " +
                      std::to_string(header.size()),
                  "complete the row");
    }
    Row row{{}, optics::zero_mueller<double>(), line_number};
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const double value = number(cells[i], {origin, line_number, header[i]});
      if (i < 4) {
        row.coordinate[i] = value;
      } else {
        optics::set_element(row.value, static_cast<int>(i - 4) / 4, static_cast<int>(i - 4) % 4,
                            value);
      }
    }
    if (row.coordinate[0] < 0.0 || row.coordinate[0] >= 90.0 ||
        std::abs(row.coordinate[1]) > 90.0) {
      throw Error({origin, line_number}, "the angles do not lie above the surface",
                  "0 <= theta_i_deg < 90 and |theta_r_deg| <= 90");
    }
    canonicalize(row);
    rows.push_back(row);
  }
  if (rows.empty()) throw Error({origin}, "the table has no rows", "add at least one row");
  return rows;
}

std::vector<double> distinct(const std::vector<Row>& rows, std::size_t coordinate) {
  std::vector<double> values;
  for (const Row& row : rows) values.push_back(row.coordinate[coordinate]);
  std::sort(values.begin(), values.end());
  values.erase(
      std::unique(values.begin(), values.end(), [](double a, double b) { return b - a < 1e-9; }),
      values.end());
  return values;
}

std::size_t index_of(const std::vector<double>& values, double x) {
  const auto found = std::lower_bound(values.begin(), values.end(), x - 1e-8);
  return static_cast<std::size_t>(found - values.begin());
}

}  // namespace

TableSample::Axis::Position TableSample::Axis::locate(double x) const {
  if (value.size() == 1 || x <= value.front()) return {0, 0.0};
  if (x >= value.back()) return {value.size() - 2, 1.0};
  const auto above = std::upper_bound(value.begin(), value.end(), x);
  const auto i = static_cast<std::size_t>(above - value.begin()) - 1;
  return {i, (x - value[i]) / (value[i + 1] - value[i])};
}

TableSample TableSample::from_text(std::string_view text, const std::string& origin) {
  const std::vector<Row> rows = read_rows(text, origin);
  TableSample sample;
  sample.name_ = origin;
  const std::array<Axis*, 4> axes = {&sample.theta_i_deg_, &sample.theta_r_deg_, &sample.phi_deg_,
                                     &sample.wavelength_nm_};
  std::size_t cells = 1;
  for (std::size_t a = 0; a < 4; ++a) {
    axes[a]->value = distinct(rows, a);
    cells *= axes[a]->value.size();
  }
  sample.grid_.assign(cells, optics::zero_mueller<double>());
  std::vector<std::size_t> line_of(cells, 0);
  for (const Row& row : rows) {
    // Where no azimuth is defined, at θr = 0, one row serves all φ when it is alone; filled in
    // below.
    std::size_t cell = 0;
    for (std::size_t a = 0; a < 4; ++a) {
      cell = cell * axes[a]->value.size() + index_of(axes[a]->value, row.coordinate[a]);
    }
    if (line_of[cell] != 0) {
      throw Error({origin, row.line},
                  "the same geometry and wavelength as in line " + std::to_string(line_of[cell]),
                  "keep one of them");
    }
    line_of[cell] = row.line;
    sample.grid_[cell] = row.value;
  }
  // A signed in-plane list has one entry at θr = 0 for both half planes: the retro side repeats it
  // with the exit basis turned by 180 degrees, which changes nothing.
  const std::size_t n_phi = sample.phi_deg_.value.size();
  const std::size_t n_wave = sample.wavelength_nm_.value.size();
  for (std::size_t i = 0; i < cells; ++i) {
    if (line_of[i] != 0) continue;
    const std::size_t wave = i % n_wave;
    const std::size_t phi = i / n_wave % n_phi;
    const std::size_t theta_r = i / n_wave / n_phi % sample.theta_r_deg_.value.size();
    const std::size_t base = i - (phi * n_wave + wave);
    const bool at_pole = sample.theta_r_deg_.value[theta_r] == 0.0;
    const std::size_t other = base + (n_phi - 1 - phi) * n_wave + wave;
    if (at_pole && n_phi == 2 && line_of[other] != 0) {
      sample.grid_[i] = sample.grid_[other];
      continue;
    }
    std::ostringstream where;
    std::size_t rest = i;
    for (std::size_t a = 4; a-- > 0;) {
      const auto& values = axes[a]->value;
      where << (a == 3 ? "" : ", ") << coordinate_names[a] << " " << values[rest % values.size()];
      rest /= values.size();
    }
    throw Error({origin}, "the table has a hole at " + where.str(),
                "give every combination of the angles and wavelengths that occur");
  }
  return sample;
}

TableSample TableSample::from_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw Error({path}, "cannot be read", "check the path and its permissions");
  std::ostringstream text;
  text << file.rdbuf();
  return from_text(text.str(), path);
}

Mueller TableSample::brdf(const Beam& in, const Beam& out, double wavelength_nm) const {
  if (in.k.z >= 0.0 || out.k.z <= 0.0) return optics::zero_mueller<double>();
  // Angles of the pair, with the plane of incidence turned to x.
  const double theta_i = std::acos(std::min(1.0, -in.k.z));
  const double theta_r = std::acos(std::min(1.0, out.k.z));
  double phi = 0.0;
  const double across = std::hypot(in.k.x, in.k.y) * std::hypot(out.k.x, out.k.y);
  if (across > 1e-12) {
    phi = std::atan2(in.k.x * out.k.y - in.k.y * out.k.x, in.k.x * out.k.x + in.k.y * out.k.y);
  } else if (std::hypot(out.k.x, out.k.y) > 1e-9) {
    phi = 0.0;  // normal incidence: the exit direction itself gives the plane
  }
  const std::array<Axis::Position, 4> at = {
      theta_i_deg_.locate(optics::degrees(theta_i)), theta_r_deg_.locate(optics::degrees(theta_r)),
      phi_deg_.locate(std::abs(optics::degrees(phi))), wavelength_nm_.locate(wavelength_nm)};
  const std::array<std::size_t, 4> size = {theta_i_deg_.value.size(), theta_r_deg_.value.size(),
                                           phi_deg_.value.size(), wavelength_nm_.value.size()};
  Mueller m = optics::zero_mueller<double>();
  for (unsigned corner = 0; corner < 16; ++corner) {
    double weight = 1.0;
    std::size_t cell = 0;
    for (std::size_t a = 0; a < 4; ++a) {
      const bool upper = (corner >> a & 1u) != 0;
      weight *= upper ? at[a].fraction : 1.0 - at[a].fraction;
      cell = cell * size[a] + std::min(at[a].index + (upper ? 1 : 0), size[a] - 1);
    }
    if (weight != 0.0) m += weight * grid_[cell];
  }
  if (phi < 0.0) m = mirrored(m);
  // The table's bases stand on the normal: rotate to the bases of the beams.
  const Vec3 z(0.0, 0.0, 1.0);
  const auto meridian = [&](const Vec3& k, const Beam& other) {
    Vec3 s = optics::cross(z, k);
    if (optics::dot(s, s) > 1e-24) return s;
    s = optics::cross(z, other.k);  // k along the normal: the other beam gives the plane
    return optics::dot(s, s) > 1e-24 ? s : in.s;
  };
  const auto entry = optics::rotation_to(in, meridian(in.k, out));
  const auto exit = optics::rotation_to(out, meridian(out.k, in));
  return optics::product(optics::rotation(exit.cos2, -exit.sin2),
                         optics::product(m, optics::rotation(entry.cos2, entry.sin2)));
}

}  // namespace umov::plant
