#include "host/calibrate/alignment.hpp"

#include <string_view>

namespace umov::calibrate {

Alignment& Alignment::operator+=(const Alignment& more) {
  theta_i_zero_deg += more.theta_i_zero_deg;
  theta_r_zero_deg += more.theta_r_zero_deg;
  sample_lean_deg += more.sample_lean_deg;
  standard_lean_deg += more.standard_lean_deg;
  return *this;
}

Alignment alignment_found(const formats::FitResult& fit, const DeclaredDoubts& declared) {
  const auto found = [&fit](std::string_view name, double u_deg) {
    for (const auto& factor : fit.factors)
      if (factor.name == name) return factor.value * u_deg;
    return 0.0;
  };
  return {found("incidence zero", declared.theta_i_zero_u_deg),
          found("detector zero", declared.theta_r_zero_u_deg),
          found("sample lean", declared.sample_lean_u_deg),
          found("standard lean", declared.sample_lean_u_deg)};
}

}  // namespace umov::calibrate
