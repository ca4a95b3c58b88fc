// Tables as plain CSV: a full grid of directions, or the two planes of a tabular model. The page
// docs/formats/table-csv.md says what every column means.
//
//   theta_i_deg,theta_r_deg,phi_r_deg,wavelength_nm,m00              unpolarised grid
//   theta_i_deg,theta_r_deg,phi_r_deg,wavelength_nm,m00,m01,…,m33   polarised grid
//   plane,theta_i_deg,angle_deg,wavelength_nm,m00                   planes; plane is `in` or
//   `across`
//
// Lines before the header line that start with '#' are comments. Rows may stand in any order.
#pragma once

#include <string>
#include <string_view>

#include "host/formats/table_file.hpp"

namespace umov::formats {

bool is_grid_csv(std::string_view bytes);
/// A brdf::GridTable. Throws umov::Error with line and column for numbers out of range, elements
/// larger than m00, directions given twice or missing from the grid, and polarised half circles
/// whose elements of U and V do not vanish in the plane of incidence.
TablePtr read_grid_csv(std::string_view bytes, const std::string& file);
/// A GridTable on its own grid, number by number; any other table on incidences 0 (5) 85 deg, exit
/// angles 0 (2.5) 87.5 deg and azimuths of the half circle that crowd about 0.
std::string write_grid_csv(const brdf::Table& table, const TableWriting& writing);

bool is_planes_csv(std::string_view bytes);
/// A brdf::PlanesTable. Throws umov::Error with line and column likewise.
TablePtr read_planes_csv(std::string_view bytes, const std::string& file);
/// A PlanesTable as it is; any other table is cut along its two planes at incidences 5, 25, 45, 60,
/// 70, 80 deg, every 2.5 deg.
std::string write_planes_csv(const brdf::Table& table, const TableWriting& writing);

}  // namespace umov::formats
