// Plans: whatever the text, the reader either refuses it with umov::Error or yields rows within the
// limits of the instrument.
// fuzz-link: umov_scan
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "host/errors/error.hpp"
#include "host/scan/plan.hpp"

namespace {

void require(bool good) {
  if (!good) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace umov::scan;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  Plan plan;
  try {
    plan = parse_plan(text, "fuzz");
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
