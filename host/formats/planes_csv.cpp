#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "host/brdf/planes_table.hpp"
#include "host/errors/error.hpp"
#include "host/formats/decimal.hpp"
#include "host/formats/number_csv.hpp"
#include "host/formats/table_csv.hpp"
#include "host/formats/table_csv_rows.hpp"
#include "host/optics/angles.hpp"

namespace umov::formats {
namespace {

constexpr std::array<std::string_view, 5> columns{"plane", "theta_i_deg", "angle_deg",
                                                  "wavelength_nm", "m00"};
constexpr std::string_view start = "plane,theta_i_deg,angle_deg,wavelength_nm,m00";
constexpr std::array<double, 6> sampled_incidences_deg{5, 25, 45, 60, 70, 80};
constexpr double sampled_step_deg = 2.5;

struct Value {
  double brdf_per_sr;
  std::size_t line;
};

/// angle -> wavelength -> value
using Profile = std::map<double, std::map<double, Value>>;

struct Planes {
  Profile in, across;
  std::size_t line = 0;  ///< of the first row at this incidence
};

brdf::PlaneProfile profile_of(const Profile& rows, const std::vector<double>& wavelengths_nm,
                              const std::string& file) {
  brdf::PlaneProfile profile;
  profile.brdf_per_sr.resize(wavelengths_nm.size());
  for (const auto& [angle_deg, values] : rows) {
    if (values.size() != wavelengths_nm.size())
      throw Error(Place{file, values.begin()->second.line, "wavelength_nm"},
                  "this direction has " + std::to_string(values.size()) +
                      " wavelengths, the file " + std::to_string(wavelengths_nm.size()),
                  "give every direction at every wavelength");
    profile.deg.push_back(angle_deg);
    std::size_t w = 0;
    for (const auto& [wavelength_nm, value] : values)
      profile.brdf_per_sr[w++].push_back(value.brdf_per_sr);
  }
  return profile;
}

/// Direction at angle β from the mirror direction in the plane across.
brdf::Geometry<double> across_direction(double theta_i, double beta) {
  const double x = std::sin(theta_i) * std::cos(beta), y = std::sin(beta),
               z = std::cos(theta_i) * std::cos(beta);
  return {theta_i, std::atan2(std::hypot(x, y), z), std::atan2(y, x)};
}

brdf::PlanesAtIncidence cut(const brdf::Table& table, const std::vector<double>& wavelengths_um,
                            double theta_i_deg) {
  brdf::PlanesAtIncidence planes;
  planes.theta_i_deg = theta_i_deg;
  planes.in_plane.brdf_per_sr.resize(wavelengths_um.size());
  planes.across.brdf_per_sr.resize(wavelengths_um.size());
  const double theta_i = optics::radians(theta_i_deg);
  const auto add = [&](brdf::PlaneProfile& profile, double deg,
                       const brdf::Geometry<double>& geometry) {
    profile.deg.push_back(deg);
    for (std::size_t w = 0; w < wavelengths_um.size(); ++w)
      profile.brdf_per_sr[w].push_back(table.at(wavelengths_um[w], geometry)[0][0]);
  };
  for (double deg = -87.5; deg <= 87.5; deg += sampled_step_deg)
    add(planes.in_plane, deg, {theta_i, optics::radians(deg), 0.0});
  for (double deg = 0; deg <= 85; deg += sampled_step_deg)
    add(planes.across, deg, across_direction(theta_i, optics::radians(deg)));
  return planes;
}

void append_profile(std::string& out, const char* plane, double theta_i_deg,
                    const brdf::PlaneProfile& profile, const std::vector<double>& wavelengths_um,
                    const std::vector<std::size_t>& chosen) {
  for (std::size_t n = 0; n < profile.deg.size(); ++n)
    for (std::size_t w = 0; w < wavelengths_um.size(); ++w) {
      out += plane;
      out += ',';
      append_row(out, std::array{theta_i_deg, profile.deg[n], nanometres(wavelengths_um[w]),
                                 profile.brdf_per_sr[chosen[w]][n]});
    }
}

}  // namespace

bool is_planes_csv(std::string_view bytes) {
  return csv_header_line(bytes.substr(0, 65536)).starts_with(start);
}

TablePtr read_planes_csv(std::string_view bytes, const std::string& file) {
  std::map<double, Planes> incidences;
  std::vector<double> wavelengths_nm;
  read_number_csv(
      bytes, file, columns, 1,
      [&](std::span<const std::string_view> texts, std::span<const double> row, std::size_t line) {
        if (texts[0] != "in" && texts[0] != "across")
          throw Error(Place{file, line, "plane"}, "should be `in` or `across`",
                      "in: the plane of incidence, across: perpendicular to it through the mirror "
                      "direction");
        require_range(file, line, columns[1], row[0], 0, 89.999);
        require_range(file, line, columns[2], row[1], -90, 90);
        require_range(file, line, columns[3], row[2], 1, 1e6);
        require_range(file, line, columns[4], row[3], 0, 1e9);
        Planes& planes = incidences[row[0]];
        if (planes.line == 0) planes.line = line;
        Profile& profile = texts[0] == "in" ? planes.in : planes.across;
        if (!profile[row[1]].try_emplace(row[2], Value{row[3], line}).second)
          throw Error(Place{file, line}, "a direction is given twice", "keep one row");
        wavelengths_nm.push_back(row[2]);
      });
  wavelengths_nm = distinct(std::move(wavelengths_nm));
  std::vector<brdf::PlanesAtIncidence> list;
  for (const auto& [theta_i_deg, planes] : incidences) {
    if (planes.in.empty() || planes.across.empty())
      throw Error(
          Place{file, planes.line, "plane"},
          "at incidence " + decimal_text(theta_i_deg) + " deg there is only one of the two planes",
          "give both `in` and `across`");
    list.push_back({theta_i_deg, profile_of(planes.in, wavelengths_nm, file),
                    profile_of(planes.across, wavelengths_nm, file)});
  }
  for (double& wavelength : wavelengths_nm) wavelength = micrometres(wavelength);
  return std::make_shared<brdf::PlanesTable>(std::move(wavelengths_nm), std::move(list), file);
}

std::string write_planes_csv(const brdf::Table& table, const TableWriting& writing) {
  const auto* planes = dynamic_cast<const brdf::PlanesTable*>(&table);
  const std::vector<double> wavelengths_um = written_wavelengths(table, writing);
  std::vector<std::size_t> chosen(wavelengths_um.size());
  TableHeader header = table_header(table, writing, wavelengths_um, false);
  std::vector<brdf::PlanesAtIncidence> list;
  if (planes) {
    list.assign(planes->incidences().begin(), planes->incidences().end());
    const auto& own = planes->wavelengths_um();
    for (std::size_t w = 0; w < wavelengths_um.size(); ++w) {
      const auto found = std::find(own.begin(), own.end(), wavelengths_um[w]);
      if (found == own.end())
        throw Error(
            "the table has no wavelength " + decimal_text(nanometres(wavelengths_um[w])) + " nm",
            "write wavelengths that it holds");
      chosen[w] = static_cast<std::size_t>(found - own.begin());
    }
  } else {
    for (const double theta_i_deg : sampled_incidences_deg)
      list.push_back(cut(table, wavelengths_um, theta_i_deg));
    for (std::size_t w = 0; w < chosen.size(); ++w) chosen[w] = w;
    header.notes.push_back(
        "cut from a full table every 2.5 deg: what lies outside the two planes is lost");
  }
  std::string out = "# format: umov planes csv\n";
  for (const std::string& line : header.lines()) out += "# " + line + "\n";
  out +=
      "# plane in: angle_deg is theta_r in the plane of incidence, negative on the side of the "
      "source\n"
      "# plane across: angle_deg is the angle from the mirror direction, perpendicular to that "
      "plane\n";
  out += std::string(start) + "\n";
  for (const auto& incidence : list) {
    append_profile(out, "in", incidence.theta_i_deg, incidence.in_plane, wavelengths_um, chosen);
    append_profile(out, "across", incidence.theta_i_deg, incidence.across, wavelengths_um, chosen);
  }
  return out;
}

}  // namespace umov::formats
