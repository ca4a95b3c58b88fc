// The calibration behind a reduction: gains, instrument function, standards.
#include <fmt/format.h>

#include <cmath>

#include "host/calibrate/calibration.hpp"
#include "host/optics/angles.hpp"
#include "host/report/json_parts.hpp"
#include "host/report/numbers.hpp"

namespace umov::report {

namespace {

constexpr double sigmas_95 = 1.96;

/// One sigma of IF at an angle, from the covariance of its coefficients (after ln C in the order).
double instrument_u(const calibrate::WavelengthCalibration& w, double theta_r_deg) {
  const auto size = static_cast<Eigen::Index>(w.instrument_function.coefficients.size());
  if (size == 0 || w.covariance.rows() < 1 + size) return 0;
  const Eigen::VectorXd basis = w.instrument_function.basis(theta_r_deg);
  const double variance = basis.dot(w.covariance.block(1, 1, size, size) * basis);
  return w.instrument_function.value(theta_r_deg) * std::sqrt(std::max(0.0, variance));
}

Json curve(const calibrate::WavelengthCalibration& w) {
  constexpr int steps = 120;
  const auto& function = w.instrument_function;
  std::vector<double> theta, value, u;
  for (int i = 0; i <= steps; ++i) {
    theta.push_back(function.min_deg + (function.max_deg - function.min_deg) * i / steps);
    value.push_back(function.value(theta.back()));
    u.push_back(instrument_u(w, theta.back()));
  }
  return {{"wavelength_nm", rounded(w.wavelength_nm, 6)},
          {"theta_r_deg", rounded(theta)},
          {"value", rounded(value, 6)},
          {"u", rounded(u, 3)}};
}

double gain_relative_u(const calibrate::WavelengthCalibration& w) {
  const double statistical = w.covariance.rows() > 0 ? w.covariance(0, 0) : 0.0;
  return std::sqrt(std::max(0.0, statistical) + w.reference_relative_u * w.reference_relative_u);
}

}  // namespace

Json calibration_data(const CalibrationInput& input) {
  const calibrate::Calibration& calibration = *input.calibration;
  Json wavelengths = Json::array(), curves = Json::array(), checks = Json::array();
  struct Row {
    const char* name;
    Json cells = Json::array();
  };
  Row gain{"gain constant C / V"}, scale{"its scale, from the standard"},
      phase{"lock-in phase / °"}, bias{"detector's bias to s, δ"}, records{"records used"},
      chi2{"χ²/dof"};
  for (const auto& w : calibration.wavelengths) {
    wavelengths.push_back(rounded(w.wavelength_nm, 6));
    gain.cells.push_back(
        with_uncertainty(w.gain_constant_v, sigmas_95 * w.gain_constant_v * gain_relative_u(w)));
    scale.cells.push_back(
        fmt::format("± {} %", plain(100 * sigmas_95 * w.reference_relative_u, 2)));
    phase.cells.push_back(
        with_uncertainty(optics::degrees(w.phase_rad), sigmas_95 * optics::degrees(w.phase_u_rad)));
    bias.cells.push_back(with_uncertainty(w.detector_bias, sigmas_95 * w.detector_bias_u) +
                         (w.bias_active ? "" : " (not applied)"));
    records.cells.push_back(count(static_cast<long long>(w.records)));
    chi2.cells.push_back(w.dof > 0 ? plain(w.chi2 / w.dof, 3) : "–");
    if (!w.instrument_function.degrees.empty()) curves.push_back(curve(w));
  }
  Json rows = Json::array();
  for (const Row* row : {&gain, &scale, &phase, &bias, &records, &chi2})
    rows.push_back({{"name", row->name}, {"cells", row->cells}});
  for (const auto& check : calibration.checks)
    checks.push_back({{"standard", check.standard},
                      {"wavelength_nm", rounded(check.wavelength_nm, 6)},
                      {"stated", plain(check.stated)},
                      {"computed", with_uncertainty(check.computed, sigmas_95 * check.computed_u)},
                      {"role", check.used_for_gain ? "fixes the gain" : "check"}});
  return {
      {"name", input.source.name},
      {"summary",
       fmt::format(
           "From {}: signal = C · BRDF · cos θr · ΔΩ · monitor / IF(θr), ΔΩ = {} sr. ± is 95 %.",
           input.source.name, plain(calibration.solid_angle_sr, 3))},
      {"wavelengths_nm", std::move(wavelengths)},
      {"rows", std::move(rows)},
      {"checks", std::move(checks)},
      {"curves", std::move(curves)},
      {"notes", calibration.notes}};
}

}  // namespace umov::report
