#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <vector>

#include "host/errors/error.hpp"
#include "host/formats/astm.hpp"
#include "host/formats/astm_columns.hpp"
#include "host/formats/astm_points.hpp"
#include "host/formats/decimal.hpp"
#include "host/formats/scan_table.hpp"
#include "host/formats/text_lines.hpp"

namespace umov::formats {
namespace {

using astm::Column;
using astm::column_of;
using astm::lower;
using astm::RawPoint;
using astm::Role;
using astm::upper;

constexpr std::size_t most_columns = 1024, most_keys = 1000;

class Reader {
 public:
  Reader(std::string_view bytes, const std::string& file) : lines_(bytes), file_(file) {}

  BrdfTable read() {
    while (read_header()) read_points();
    if (points_.empty())
      fail({}, "there are no points", "the file must have a VARS line and points after it");
    return table();
  }

 private:
  [[noreturn]] void fail(std::string_view column, const std::string& problem,
                         const std::string& remedy) const {
    throw Error(Place{file_, lines_.line_number(), std::string(column)}, problem, remedy);
  }

  bool next_line() {
    if (pushed_back_) {
      pushed_back_ = false;
      return true;
    }
    while (lines_.next(line_)) {
      if (is_blank(line_) || line_.starts_with('#')) continue;
      lines_.require_line_end(line_, file_);
      return true;
    }
    return false;
  }

  /// Keys up to and including VARS; false at the end of the file. Keys of earlier blocks stay
  /// valid.
  bool read_header() {
    block_points_.reset();
    bool any = false;
    while (next_line()) {
      any = true;
      const std::string_view line = trimmed(line_);
      const std::size_t gap = std::min(line.find_first_of(" \t"), line.size());
      const std::string key = upper(line.substr(0, gap));
      const std::string value(trimmed(line.substr(gap)));
      if (key == "VARS") {
        read_columns(value);
        return true;
      }
      if (!std::isalpha(static_cast<unsigned char>(key.front())))
        fail({}, "a point before the line VARS",
             "name the columns first: VARS theta_i,phi_i,theta_s,phi_s,BRDF");
      if (key == "NUM_POINTS") {
        std::int64_t count = 0;
        if (read_integer(value, count) != nullptr || count < 1)
          fail(key, "is no number of points", "give a whole number");
        block_points_ = count;
      } else if (key == "NOTE" && value.find(": ") != std::string::npos) {
        notes_.emplace_back(value.substr(0, value.find(": ")), value.substr(value.find(": ") + 2));
      } else {
        if (keys_.size() >= most_keys)
          fail(key, "there are too many header lines", "is this an ASTM file?");
        if (!keys_.contains(key)) order_.push_back(key);
        keys_[key] = value;
      }
    }
    if (any) fail({}, "the header has no line VARS", "the file may be cut off");
    return false;
  }

  void read_columns(const std::string& list) {
    columns_.clear();
    std::vector<std::string_view> names;
    split_fields(list, names);
    if (names.size() > most_columns)
      fail("VARS", "there are too many columns", "is this an ASTM file?");
    bool has_value = false;
    for (const std::string_view given : names) {
      const std::string name = upper(given);
      if (name == "R" || name == "G" || name == "B" || name == "X" || name == "Y" || name == "Z")
        fail("VARS", "colour channels have no wavelengths",
             "name the columns by their wavelength, such as 550nm");
      const auto column = column_of(name);
      if (!column)
        fail("VARS", "unknown column `" + std::string(given.substr(0, 40)) + "`",
             "known: theta_i, phi_i, theta_s, phi_s, wavelength_nm, pol_i, pol_s, BRDF, BRDF_u, "
             "CCBRDF, "
             "CCBRDF_u, used, <number>nm, u_<number>nm");
      for (const Column& other : columns_)
        if (other.name == name)
          fail("VARS", "column `" + name + "` is named twice", "name each column once");
      has_value |= column->role == Role::value;
      columns_.push_back(*column);
    }
    for (Column& value : columns_)
      for (std::size_t u = 0; value.role == Role::value && u < columns_.size(); ++u)
        if (columns_[u].role == Role::uncertainty &&
            columns_[u].times_cosine == value.times_cosine &&
            columns_[u].wavelength_nm == value.wavelength_nm)
          value.uncertainty = u;
    if (!has_value) fail("VARS", "no column holds a BRDF", "name it BRDF, CCBRDF or <number>nm");
    if (!has(Role::theta_i) && !keys_.contains("THETA_I"))
      fail("VARS", "the angle of incidence is not given",
           "add a column theta_i or a header line THETA_I");
    if (!has(Role::theta_s)) fail("VARS", "the scatter angle is not given", "add a column theta_s");
  }

  bool has(Role role) const {
    return std::any_of(columns_.begin(), columns_.end(),
                       [&](const Column& c) { return c.role == role; });
  }

  std::optional<double> key_number(const std::string& key) const {
    const auto found = keys_.find(key);
    if (found == keys_.end()) return std::nullopt;
    double value = 0;
    if (const char* problem = read_decimal(found->second, value))
      fail(key, std::string(problem) + ": \"" + found->second.substr(0, 40) + "\"",
           "give a plain decimal number");
    return value;
  }

  /// "632.8 nm" or "0.6328 um".
  std::optional<double> key_wavelength_nm() const {
    const auto found = keys_.find("WAVELENGTH");
    if (found == keys_.end()) return std::nullopt;
    const std::string text = lower(found->second);
    double value = 0;
    for (const auto& [unit, factor] : {std::pair{"nm", 1.0}, {"um", 1e3}})
      if (text.ends_with(unit) &&
          !read_decimal(trimmed(std::string_view(text).substr(0, text.size() - 2)), value))
        return std::round(value * factor * 1e9) / 1e9;
    fail("WAVELENGTH", "has no number with unit",
         "write WAVELENGTH 632.8 nm or WAVELENGTH 0.6328 um");
  }

  /// S, P, U, or the axis in degrees from p towards s.
  double axis(std::string_view text, const std::string& column) const {
    const std::string name = upper(text);
    if (name == "U" || name == "OPEN") return open_axis;
    if (name == "P") return 0;
    if (name == "S") return 90;
    double value = 0;
    if (read_decimal(text, value) != nullptr || std::abs(value) > 360)
      fail(column, "is no polarisation: \"" + std::string(text.substr(0, 40)) + "\"",
           "give S, P, U or an angle in degrees");
    return value;
  }

  double key_axis(const std::string& key) const {
    const auto found = keys_.find(key);
    return found == keys_.end() ? open_axis : axis(found->second, key);
  }

  void read_points() {
    RawPoint base{};
    base.theta_i = key_number("THETA_I").value_or(0);
    // Without a scatter azimuth the block is in plane; one without an incident azimuth counts from
    // the forward direction.
    in_plane_ = !has(Role::phi_s);
    const bool origin = has(Role::phi_i) || keys_.contains("PHI_I");
    base.phi_i = in_plane_ ? 0 : key_number("PHI_I").value_or(0);
    base.specular_azimuth_deg =
        in_plane_ ? 0 : key_number("SPECULAR_AZIMUTH").value_or(origin ? 180 : 0);
    const auto wavelength_nm = key_wavelength_nm();
    base.polarizer_deg = key_axis("POLARIZATION_I");
    base.analyzer_deg = key_axis("POLARIZATION_S");
    std::vector<std::string_view> fields;
    std::int64_t count = 0;
    while (next_line()) {
      if (std::isalpha(static_cast<unsigned char>(trimmed(line_).front()))) {
        pushed_back_ = true;  // the header of the next block
        break;
      }
      split_fields(line_, fields);
      if (fields.size() != columns_.size())
        fail({},
             "the line has " + std::to_string(fields.size()) + " fields, not " +
                 std::to_string(columns_.size()),
             "one value a column of VARS; the file may have been cut off");
      if (block_points_ && count == *block_points_)
        fail("NUM_POINTS", "there are more than the " + std::to_string(count) + " points announced",
             "correct NUM_POINTS");
      ++count;
      read_point(fields, base, wavelength_nm);
    }
    if (block_points_ && count != *block_points_)
      fail("NUM_POINTS",
           std::to_string(count) + " points of " + std::to_string(*block_points_) + " announced",
           "the file may be cut off");
  }

  void read_point(const std::vector<std::string_view>& fields, RawPoint point,
                  std::optional<double> wavelength_nm) {
    point.line = lines_.line_number();
    point.used = 1;
    for (std::size_t c = 0; c < columns_.size(); ++c) {
      const Column& column = columns_[c];
      if (column.role == Role::pol_i) {
        point.polarizer_deg = axis(fields[c], column.name);
        continue;
      }
      if (column.role == Role::pol_s) {
        point.analyzer_deg = axis(fields[c], column.name);
        continue;
      }
      double value = 0;
      if (const char* problem = read_decimal(fields[c], value))
        fail(column.name,
             std::string(problem) + ": \"" + std::string(fields[c].substr(0, 40)) + "\"",
             "give a plain decimal number");
      if (column.role == Role::theta_i) point.theta_i = value;
      if (column.role == Role::phi_i && !in_plane_) point.phi_i = value;
      if (column.role == Role::theta_s) point.theta_s = value;
      if (column.role == Role::phi_s) point.phi_s = value;
      if (column.role == Role::wavelength) wavelength_nm = value;
      if (column.role == Role::used) point.used = value != 0;
      if (column.role == Role::value && std::abs(value) > 1e9)
        fail(column.name, "is no BRDF", "values are in 1/sr");
      if (column.role == Role::uncertainty && !(value >= 0 && value < 1e9))
        fail(column.name, "is no uncertainty", "one standard deviation in 1/sr");
      numbers_.resize(columns_.size());
      numbers_[c] = value;
    }
    for (std::size_t c = 0; c < columns_.size(); ++c) {
      if (columns_[c].role != Role::value) continue;
      point.value = numbers_[c];
      point.times_cosine = columns_[c].times_cosine;
      const auto nm = columns_[c].wavelength_nm ? columns_[c].wavelength_nm : wavelength_nm;
      if (!nm)
        fail("VARS", "the wavelength is not given",
             "add a line WAVELENGTH 632.8 nm or a column wavelength_nm");
      if (!(*nm > 50 && *nm < 1e5))
        fail("WAVELENGTH", decimal_text(*nm) + " nm is out of range", "check its unit");
      point.wavelength_nm = *nm;
      point.uncertainty.reset();
      if (columns_[c].uncertainty) point.uncertainty = numbers_[*columns_[c].uncertainty];
      points_.push_back(point);
    }
  }

  /// To degrees: by key, or because some angle is too large for radians.
  double degrees_per_unit() const {
    if (const auto found = keys_.find("ANGLE_UNITS"); found != keys_.end()) {
      const std::string unit = upper(found->second);
      if (unit.starts_with("DEG")) return 1;
      if (unit.starts_with("RAD")) return 180 / std::numbers::pi;
      throw Error(Place{file_, 0, "ANGLE_UNITS"}, "should be DEGREES or RADIANS",
                  "correct the header line");
    }
    for (const RawPoint& p : points_)
      if (std::max(p.theta_i, std::abs(p.theta_s)) > std::numbers::pi / 2 + 1e-3) return 1;
    throw Error(Place{file_, 0, "ANGLE_UNITS"}, "polar angles up to 1.57 may be degrees or radians",
                "add a header line ANGLE_UNITS DEGREES or ANGLE_UNITS RADIANS before VARS");
  }

  BrdfTable table() const {
    BrdfTable table;
    const double degrees = degrees_per_unit();
    const auto relative = key_number("RELATIVE_UNCERTAINTY");
    if (relative && !(*relative >= 0 && *relative < 10))
      throw Error(Place{file_, 0, "RELATIVE_UNCERTAINTY"}, "is out of range", "0.02 means 2 %");
    bool assumed = false;
    for (const RawPoint& point : points_) {
      const bool none = !point.uncertainty;
      assumed |= none && !relative;
      astm::add_point(table.points, point, degrees, none ? relative : std::nullopt, file_);
    }
    astm::assume_uncertainties(table.points);
    static const std::array<std::string_view, 9> understood{
        "ANGLE_UNITS",    "SPECULAR_AZIMUTH", "WAVELENGTH",           "THETA_I", "PHI_I",
        "POLARIZATION_I", "POLARIZATION_S",   "RELATIVE_UNCERTAINTY", "QUANTITY"};
    for (const std::string& key : order_)
      if (key != "ASTM" && std::find(understood.begin(), understood.end(), key) == understood.end())
        table.keys.emplace_back(lower(key), keys_.at(key));
    for (const auto& note : notes_) table.keys.push_back(note);
    if (assumed)
      table.keys.emplace_back("uncertainty",
                              "assumed: 5 % of the value and the noise that values below zero "
                              "show; the file states none");
    return table;
  }

  LineReader lines_;
  std::string file_;
  std::string_view line_;
  bool pushed_back_ = false;
  std::map<std::string, std::string> keys_;
  std::vector<std::string> order_;
  std::vector<std::pair<std::string, std::string>> notes_;
  std::optional<std::int64_t> block_points_;
  bool in_plane_ = false;
  std::vector<Column> columns_;
  std::vector<double> numbers_;
  std::vector<RawPoint> points_;
};

}  // namespace

bool is_astm(std::string_view bytes) {
  LineReader lines(bytes.substr(0, 65536));
  std::string_view line;
  bool points = false;
  while (lines.next(line)) {
    if (is_blank(line) || line.starts_with('#')) continue;
    const std::string start = upper(trimmed(line).substr(0, 10));
    if (start.starts_with("ASTM")) return true;
    if (start.starts_with("NUM_POINTS")) points = true;
    if (start.starts_with("VARS ") || start.starts_with("VARS\t")) return points;
    if (!std::isalpha(static_cast<unsigned char>(start.front()))) return false;
  }
  return false;
}

BrdfTable read_astm(std::string_view bytes, const std::string& file) {
  return Reader(bytes, file).read();
}

}  // namespace umov::formats
