#include "host/formats/foreign_kind.hpp"

#include "host/formats/number_csv.hpp"

namespace umov::formats {

ForeignKind foreign_kind(std::string_view text) {
  const std::string_view header = csv_header_line(text);
  if (header.starts_with("lambda,thetai,phi,thetar,phir,")) return ForeignKind::nist_ptfe;
  if (header.starts_with("material,theta_r_deg,theta_i_deg,radiance")) return ForeignKind::jsss;
  // A scan with a wrong column is still meant as one, and is refused with the column's name.
  if (header.find("x_v") != std::string_view::npos ||
      header.find("theta_r") != std::string_view::npos || header.starts_with("index,"))
    return ForeignKind::scan_csv;
  return ForeignKind::unknown;
}

}  // namespace umov::formats
