// The columns of a reduced measurement, declared once: brdf.h5 and its CSV are made from this
// table.
#pragma once

#include <string>

#include "host/formats/brdf_table.hpp"

namespace umov::formats {

struct BrdfColumn {
  const char* group;  ///< points, dolp or dhr
  const char* name;
  const char* unit;
  bool axis = false;  ///< NaN stands for `open`
  std::string path() const { return std::string("/") + group + "/" + name; }
};

/// Calls visit(column, values, length of the column's group) in the order of the file.
template <class Table, class Visit>
void for_each_brdf_column(Table& table, Visit visit) {
  auto& p = table.points;
  const auto np = p.size();
  visit(BrdfColumn{"points", "theta_i_deg", "deg"}, p.theta_i_deg, np);
  visit(BrdfColumn{"points", "theta_r_deg", "deg"}, p.theta_r_deg, np);
  visit(BrdfColumn{"points", "phi_r_deg", "deg"}, p.phi_r_deg, np);
  visit(BrdfColumn{"points", "wavelength_nm", "nm"}, p.wavelength_nm, np);
  visit(BrdfColumn{"points", "polarizer_deg", "deg", true}, p.polarizer_deg, np);
  visit(BrdfColumn{"points", "analyzer_deg", "deg", true}, p.analyzer_deg, np);
  visit(BrdfColumn{"points", "brdf_per_sr", "1/sr"}, p.brdf_per_sr, np);
  visit(BrdfColumn{"points", "brdf_u", "1/sr"}, p.brdf_u, np);
  visit(BrdfColumn{"points", "used", "1"}, p.used, np);
  auto& d = table.dolp;
  const auto nd = d.dolp.size();
  visit(BrdfColumn{"dolp", "theta_i_deg", "deg"}, d.theta_i_deg, nd);
  visit(BrdfColumn{"dolp", "theta_r_deg", "deg"}, d.theta_r_deg, nd);
  visit(BrdfColumn{"dolp", "phi_r_deg", "deg"}, d.phi_r_deg, nd);
  visit(BrdfColumn{"dolp", "wavelength_nm", "nm"}, d.wavelength_nm, nd);
  visit(BrdfColumn{"dolp", "dolp", "1"}, d.dolp, nd);
  visit(BrdfColumn{"dolp", "dolp_u", "1"}, d.dolp_u, nd);
  auto& h = table.dhr;
  const auto nh = h.dhr.size();
  visit(BrdfColumn{"dhr", "wavelength_nm", "nm"}, h.wavelength_nm, nh);
  visit(BrdfColumn{"dhr", "theta_i_deg", "deg"}, h.theta_i_deg, nh);
  visit(BrdfColumn{"dhr", "dhr", "1"}, h.dhr, nh);
  visit(BrdfColumn{"dhr", "dhr_u", "1"}, h.dhr_u, nh);
}

}  // namespace umov::formats
