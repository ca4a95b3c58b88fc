// Plans: whatever the text, the reader either refuses it with umov::Error or yields rows within the
// limits of the instrument.
// fuzz-link: umov_scan
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "host/errors/error.hpp"
#include "host/scan/plan.hpp"
#include "tests/fuzz/foreign_bytes.hpp"

namespace {

using umov::fuzz::require;

constexpr std::string_view in_plane = R"(# a
sample = "red-gloss"
role = "sample"
wavelengths_nm = [532, 633]
theta_i_deg = [0, 30]
theta_r_deg = { from = -60, to = 60, step = 20, near = { within_deg = 5, step = 1 } }
states = [["P", "P"], ["P", "open"], [45, -45.5]]
order = "random"
seed = 7
dwell_ms = 50
)";
constexpr std::string_view blocks = R"(sample = "black"
wavelengths_nm = [532]
theta_i_deg = { from = 5, to = 70, step = 32.5 }
theta_r_deg = [-40, 40]
states = [["P", "P"], ["S", "S"]]
order = "serpentine"

[[block]]
menu = "nd"
optical_density = [0, 1.5]

[[block]]
menu = "iris"
iris_fraction = 0.5

[[block]]
menu = "oop"
phi_r_deg = [30, 150]
theta_r_deg = [20, 70]

[[block]]
menu = "white_tile"
sample = "white-99"
reference_dhr = { 532 = 0.99 }

[[block]]
menu = "repeat"
repeats = 3
)";
constexpr std::array<std::string_view, 2> originals{in_plane, blocks};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace umov::scan;
  Plan plan;
  try {
    plan = parse_plan(umov::fuzz::foreign_bytes(originals, data, size).bytes, "fuzz");
  } catch (const umov::Error&) {
    return 0;
  }
  const std::size_t count = row_count(plan);
  require(count > 0 && count <= max_plan_rows);
  if (count > 20'000) return 0;  // the same code, only slower
  const Program program = expand(plan);
  require(program.rows.size() == count);
  for (const PlanRow& row : program.rows) {
    require(row.theta_i_deg >= 0 && row.theta_i_deg <= 90);
    require(std::abs(row.theta_r_deg) <= 90);
    require(row.phi_r_deg == 0 || row.theta_r_deg >= 0);
    require(row.dwell_ms >= 1 && row.dwell_ms <= 60000);
    require(row.optical_density >= 0 && row.optical_density <= 5);
  }
  require(program_id(plan) != 0);
  return 0;
}
