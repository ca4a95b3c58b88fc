#include <algorithm>
#include <cctype>
#include <cmath>

#include "host/formats/astm.hpp"
#include "host/formats/decimal.hpp"
#include "host/formats/scan_table.hpp"

namespace umov::formats {
namespace {

/// In this file's frame the source stands at azimuth 180 deg, so that phi_s is our φ.
constexpr double source_azimuth_deg = 180;

std::string axis_text(double axis_deg) {
  if (is_open(axis_deg)) return "U";
  if (axis_deg == 0) return "P";
  if (axis_deg == 90) return "S";
  return decimal_text(axis_deg);
}

std::string one_line(std::string_view text) {
  std::string out;
  for (const char c : text) out += c < ' ' ? ' ' : c;
  return out;
}

/// Words of the header that are one keyword stand as such, others as NOTE.
void append_key(std::string& out, const std::string& key, const std::string& value) {
  static constexpr std::string_view reserved[] = {
      "astm",           "vars",           "num_points",
      "note",           "angle_units",    "specular_azimuth",
      "wavelength",     "theta_i",        "phi_i",
      "polarization_i", "polarization_s", "relative_uncertainty",
      "quantity"};
  const bool word = !key.empty() && std::isalpha(static_cast<unsigned char>(key.front())) &&
                    std::all_of(key.begin(), key.end(), [](unsigned char c) {
                      return std::islower(c) || std::isdigit(c) || c == '_';
                    });
  if (!word || trimmed(value).empty() ||
      std::find(std::begin(reserved), std::end(reserved), key) != std::end(reserved)) {
    // The first colon ends the key.
    std::string name = one_line(key);
    std::replace(name.begin(), name.end(), ':', ';');
    out += "NOTE " + name + ": " + one_line(value) + "\n";
    return;
  }
  for (const char c : key) out += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  out += " " + one_line(value) + "\n";
}

}  // namespace

std::string write_astm(const BrdfTable& table, const TableWriting& writing) {
  std::string out = "ASTM E2387\n";
  out +=
      "# BRDF in 1/sr, not multiplied by cos theta; angles in degrees\n"
      "# phi_i is the azimuth of the source; specular light goes to phi_s - phi_i = 180\n"
      "# pol_i, pol_s: S, P, U (no polariser) or the axis in degrees from p towards s\n"
      "# BRDF_u: one standard deviation, independent from point to point\n";
  if (!writing.program.empty()) out += "# program: " + one_line(writing.program) + "\n";
  if (!writing.command.empty()) out += "# command: " + one_line(writing.command) + "\n";
  for (const std::string& note : writing.notes) out += "# note: " + one_line(note) + "\n";
  for (const BrdfTable::Factor& factor : table.factors)
    out += "# shared uncertainty not in this file: " + one_line(factor.name) + "\n";
  if (!table.dolp.dolp.empty()) out += "# DOLP is not in this file\n";
  if (!table.dhr.dhr.empty()) out += "# DHR is not in this file\n";
  if (table.mueller) out += "# Mueller matrices are not in this file\n";
  for (const auto& [key, value] : table.keys) append_key(out, key, value);
  out += "ANGLE_UNITS DEGREES\nSPECULAR_AZIMUTH 180\n";
  const auto& p = table.points;
  out += "NUM_POINTS " + std::to_string(p.size()) + "\n";
  out += "VARS theta_i,phi_i,theta_s,phi_s,wavelength_nm,pol_i,pol_s,BRDF,BRDF_u,used\n";
  for (std::size_t n = 0; n < p.size(); ++n) {
    double theta_s = p.theta_r_deg[n], phi_s = p.phi_r_deg[n];
    if (theta_s < 0) {
      theta_s = -theta_s;
      phi_s = std::remainder(phi_s + 180, 360);
    }
    for (const std::string& cell :
         {decimal_text(p.theta_i_deg[n]), decimal_text(source_azimuth_deg), decimal_text(theta_s),
          decimal_text(phi_s), decimal_text(p.wavelength_nm[n]), axis_text(p.polarizer_deg[n]),
          axis_text(p.analyzer_deg[n]), decimal_text(p.brdf_per_sr[n]), decimal_text(p.brdf_u[n])})
      out += cell + ",";
    out += std::to_string(p.used[n]) + "\n";
  }
  return out;
}

}  // namespace umov::formats
