#include "host/formats/jsss_scan.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "host/errors/error.hpp"
#include "host/formats/atomic_file.hpp"
#include "host/formats/number_csv.hpp"
#include "host/formats/order_statistics.hpp"
#include "host/formats/scan_table.hpp"

namespace umov::formats {
namespace {

constexpr std::array<std::string_view, 4> scan_header = {"material", "theta_r_deg", "theta_i_deg",
                                                         "radiance_w_m2_sr"};
constexpr std::array<std::string_view, 4> emissivity_header = {"material", "theta_deg",
                                                               "emissivity", "standard_deviation"};
/// Camera band 2 to 5.7 micrometres; its middle stands for the wavelength.
constexpr double band_middle_nm = 3850;
/// Mean violation of reciprocity by the diffuse metals, divided between the two directions.
constexpr double relative_u = 0.03;

void check(bool good, const std::string& name, std::size_t line, std::string_view column,
           const char* problem) {
  if (!good)
    throw Error(Place{name, line, std::string(column)}, problem,
                "check the line against its source");
}

JsssScan parse_scan(std::string_view text, const std::string& name) {
  JsssScan scan;
  read_number_csv(
      text, name, scan_header, 1,
      [&](std::span<const std::string_view> texts, std::span<const double> row, std::size_t line) {
        check(!texts[0].empty(), name, line, "material", "no name");
        check(row[0] >= -90 && row[0] <= 90, name, line, "theta_r_deg", "not within -90 to 90 deg");
        check(row[1] >= 0 && row[1] < 90, name, line, "theta_i_deg", "not from 0 to below 90 deg");
        scan.material.emplace_back(texts[0]);
        scan.theta_r_deg.push_back(row[0]);
        scan.theta_i_deg.push_back(row[1]);
        scan.radiance_w_m2_sr.push_back(row[2]);
      });
  return scan;
}

JsssEmissivity parse_emissivity(std::string_view text, const std::string& name) {
  JsssEmissivity table;
  read_number_csv(
      text, name, emissivity_header, 1,
      [&](std::span<const std::string_view> texts, std::span<const double> row, std::size_t line) {
        check(row[0] >= 0 && row[0] <= 90, name, line, "theta_deg", "not within 0 to 90 deg");
        check(row[1] >= 0 && row[1] <= 1.2, name, line, "emissivity", "not between 0 and 1");
        check(row[2] >= 0, name, line, "standard_deviation", "below 0");
        table.material.emplace_back(texts[0]);
        table.theta_deg.push_back(row[0]);
        table.emissivity.push_back(row[1]);
        table.standard_deviation.push_back(row[2]);
      });
  return table;
}

/// Noise of the darkest quarter, from second differences along each camera angle.
double radiance_floor(const std::vector<double>& theta_r_deg, const std::vector<double>& radiance) {
  std::vector<double> sorted = radiance;
  std::sort(sorted.begin(), sorted.end());
  const double dark = sorted[sorted.size() / 4];
  std::vector<double> differences;
  for (std::size_t i = 1; i + 1 < radiance.size(); ++i)
    if (radiance[i] <= dark && theta_r_deg[i - 1] == theta_r_deg[i + 1])
      differences.push_back(std::abs(radiance[i - 1] - 2 * radiance[i] + radiance[i + 1]));
  // A normal second difference has variance 6 and median |.| of .6745 sigma.
  return median(differences) / 0.6745 / std::sqrt(6.0);
}

}  // namespace

std::vector<std::string> JsssScan::materials() const {
  std::vector<std::string> names;
  for (const std::string& name : material)
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  return names;
}

JsssScan read_jsss_scan(const std::filesystem::path& path) {
  return parse_scan(read_whole_file(path), path.string());
}

JsssScan read_jsss_scan(std::istream& in, const std::string& name) {
  return parse_scan(read_stream(in, name), name);
}

JsssEmissivity read_jsss_emissivity(const std::filesystem::path& path) {
  return parse_emissivity(read_whole_file(path), path.string());
}

JsssEmissivity read_jsss_emissivity(std::istream& in, const std::string& name) {
  return parse_emissivity(read_stream(in, name), name);
}

BrdfTable to_brdf_table(const JsssScan& scan, const std::string& material,
                        const JsssEmissivity* emissivity) {
  BrdfTable brdf;
  brdf.keys = {{"sample", material},
               {"role", "sample"},
               {"source", "JSSS gonioreflectometer, mid infrared, in plane (CC0)"},
               {"relative_units", "1"},
               {"band_nm", "2000-5700"}};
  std::vector<double> radiance;
  auto& p = brdf.points;
  for (std::size_t n = 0; n < scan.size(); ++n) {
    if (scan.material[n] != material) continue;
    p.theta_i_deg.push_back(scan.theta_i_deg[n]);
    p.theta_r_deg.push_back(scan.theta_r_deg[n]);
    p.phi_r_deg.push_back(0);
    p.wavelength_nm.push_back(band_middle_nm);
    p.polarizer_deg.push_back(open_axis);
    p.analyzer_deg.push_back(open_axis);
    radiance.push_back(scan.radiance_w_m2_sr[n]);
  }
  if (radiance.empty()) {
    std::string names;
    for (const std::string& name : scan.materials()) names += (names.empty() ? "" : ", ") + name;
    throw Error("the scan has no material \"" + material + "\"", "it has: " + names);
  }
  const double floor = radiance_floor(p.theta_r_deg, radiance);
  for (std::size_t n = 0; n < radiance.size(); ++n) {
    // The source is small and of constant radiance: its irradiance goes as cos theta_i. With this
    // division the diffuse metals obey reciprocity within 3 %, without it they fail by 60 %.
    const double cos_i = std::cos(p.theta_i_deg[n] * std::numbers::pi / 180);
    p.brdf_per_sr.push_back(radiance[n] / cos_i);
    p.brdf_u.push_back(std::hypot(relative_u * radiance[n], floor) / cos_i);
    p.used.push_back(radiance[n] > 3 * floor ? 1 : 0);
  }
  if (emissivity != nullptr)
    for (std::size_t n = 0; n < emissivity->size(); ++n) {
      if (emissivity->material[n] != material) continue;
      brdf.dhr.wavelength_nm.push_back(band_middle_nm);
      brdf.dhr.theta_i_deg.push_back(emissivity->theta_deg[n]);
      brdf.dhr.dhr.push_back(1 - emissivity->emissivity[n]);
      brdf.dhr.dhr_u.push_back(emissivity->standard_deviation[n]);
    }
  return brdf;
}

}  // namespace umov::formats
