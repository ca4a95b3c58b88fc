#include "host/formats/brdf_csv.hpp"

#include <cmath>
#include <initializer_list>

#include "host/formats/decimal.hpp"
#include "host/formats/scan_table.hpp"

namespace umov::formats {
namespace {

std::string axis_text(double axis_deg) {
  return is_open(axis_deg) ? "open" : decimal_text(axis_deg);
}

void append_line(std::string& out, std::initializer_list<std::string> cells) {
  const char* separator = "";
  for (const std::string& cell : cells) {
    out += separator + cell;
    separator = ",";
  }
  out += "\n";
}

void append_mueller(std::string& out, const BrdfTable::Mueller& m) {
  for (std::size_t n = 0; n < m.size(); ++n)
    for (std::size_t k = 0; k < m.elements(); ++k) {
      const std::size_t at = n * m.elements() + k, side = static_cast<std::size_t>(m.side);
      if (std::isnan(m.mueller[at])) continue;
      append_line(out, {"m" + std::to_string(k / side) + std::to_string(k % side),
                        decimal_text(m.wavelength_nm[n]), decimal_text(m.theta_i_deg[n]),
                        decimal_text(m.theta_r_deg[n]), decimal_text(m.phi_r_deg[n]), "", "",
                        decimal_text(m.mueller[at]), decimal_text(m.mueller_u[at]), "1"});
    }
}

}  // namespace

std::string brdf_csv_text(const BrdfTable& table) {
  std::string out = "# format: umov brdf csv\n";
  for (const auto& [key, value] : table.keys)
    if (key != "format") out += "# " + key + ": " + value + "\n";
  for (const BrdfTable::Factor& factor : table.factors)
    out += "# shared uncertainty not in this file: " + factor.name + "\n";
  out +=
      "quantity,wavelength_nm,theta_i_deg,theta_r_deg,phi_r_deg,polarizer_deg,analyzer_deg,value,"
      "uncertainty,used\n";
  const auto& p = table.points;
  for (std::size_t n = 0; n < p.size(); ++n)
    append_line(out, {"brdf", decimal_text(p.wavelength_nm[n]), decimal_text(p.theta_i_deg[n]),
                      decimal_text(p.theta_r_deg[n]), decimal_text(p.phi_r_deg[n]),
                      axis_text(p.polarizer_deg[n]), axis_text(p.analyzer_deg[n]),
                      decimal_text(p.brdf_per_sr[n]), decimal_text(p.brdf_u[n]),
                      std::to_string(p.used[n])});
  const auto& d = table.dolp;
  for (std::size_t n = 0; n < d.dolp.size(); ++n)
    append_line(out, {"dolp", decimal_text(d.wavelength_nm[n]), decimal_text(d.theta_i_deg[n]),
                      decimal_text(d.theta_r_deg[n]), decimal_text(d.phi_r_deg[n]), "", "",
                      decimal_text(d.dolp[n]), decimal_text(d.dolp_u[n]), "1"});
  const auto& h = table.dhr;
  for (std::size_t n = 0; n < h.dhr.size(); ++n)
    append_line(out, {"dhr", decimal_text(h.wavelength_nm[n]), decimal_text(h.theta_i_deg[n]), "",
                      "", "", "", decimal_text(h.dhr[n]), decimal_text(h.dhr_u[n]), "1"});
  if (table.mueller) append_mueller(out, *table.mueller);
  return out;
}

}  // namespace umov::formats
