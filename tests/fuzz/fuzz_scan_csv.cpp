// Scan CSV: whatever the text, the reader either refuses it with umov::Error or yields a table that
// goes through text unchanged.
// fuzz-link: umov_formats
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "host/errors/error.hpp"
#include "host/formats/scan_csv.hpp"
#include "host/formats/scan_h5.hpp"
#include "tests/fuzz/foreign_bytes.hpp"

namespace {

using umov::fuzz::require;

constexpr std::array<std::string_view, 1> originals{
    "# format: umov scan csv\n# sample: coupon\n# solid_angle_sr: 1e-4\n# block: main 0-1\n"
    "# block: flip 2-2 sample_azimuth_deg=180 note=x\n"
    "index,time_s,theta_i_deg,theta_r_deg,phi_r_deg,wavelength_nm,polarizer_deg,analyzer_deg,"
    "direction,gain,x_v,y_v,x_se_v,y_se_v,monitor_v,saturated,shutter\n"
    "0,0.450,30,-80,0,532,0,open,1,100,0.0021820908,-6.2942505e-06,5.958e-06,5.09e-06,1.080726,0,"
    "open\n"
    "1,1.000,30,12.5,0,532,90,0,-1,10,0.1,0,1e-05,1e-05,1,1,closed\n"
    "2,1.550,30,40,150,532,-45,45,1,1,1.5,-0,0,0,0.9,0,open\n"};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace umov::formats;
  ScanTable table;
  try {
    table = parse_scan_csv(umov::fuzz::foreign_bytes(originals, data, size).bytes, "fuzz");
  } catch (const umov::Error&) {
    return 0;
  }
  const std::string once = scan_csv_text(table);
  const ScanTable again = parse_scan_csv(once, "again");
  require(content_sha256(again) == content_sha256(table));
  require(scan_csv_text(again) == once);
  return 0;
}
