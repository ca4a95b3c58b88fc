// A reduced measurement as CSV, for spreadsheets and scripts. Written only; brdf.h5 is the record.
//
// Comment lines `# key: value`, then the columns quantity,wavelength_nm,theta_i_deg,theta_r_deg,
// phi_r_deg,polarizer_deg,analyzer_deg,value,uncertainty,used. `quantity` is brdf (1/sr), dolp,
// dhr or a Mueller element (m00, m01 …; 1/sr); cells that have no meaning for it are empty; an open polariser or analyser is `open`.
// `uncertainty` is one sigma, the part independent from point to point.
#pragma once

#include <string>

#include "host/formats/brdf_table.hpp"

namespace umov::formats {

std::string brdf_csv_text(const BrdfTable& table);

}  // namespace umov::formats
