#include "host/calibrate/standard_rows.hpp"

#include <cmath>

#include "host/formats/order_statistics.hpp"
#include "host/optics/angles.hpp"

namespace umov::calibrate {

namespace {

constexpr double degree = optics::radians(1.0);

double cos_twice(double axis_deg) {
  return formats::is_open(axis_deg) ? 0.0 : std::cos(2.0 * axis_deg * degree);
}

/// Q/I of light that leaves the standard, from its own table; 0 for a depolarising one.
double polarisation(const ReferenceStandard& reference, const formats::ScanTable& scan,
                    std::size_t i) {
  if (!reference.polarised()) return 0;
  const auto behind = [&](double analyzer) {
    return reference.brdf(scan.theta_i_deg[i], scan.theta_r_deg[i], scan.phi_r_deg[i],
                          scan.wavelength_nm[i], scan.polarizer_deg[i], analyzer);
  };
  const auto s = behind(90.0), p = behind(0.0);
  return s && p && *s + *p > 0 ? (*s - *p) / (*s + *p) : 0.0;
}

/// Volts of stray light per level (1/sr) are C times this.
double stray_base(const PreparedStandard& input, std::size_t i) {
  const formats::ScanTable& scan = input.standard->scan;
  return stray_share(scan.analyzer_deg[i]) * input.solid_angle_sr * scan.monitor_v[i];
}

/// How much more light than ideal elements do the true ones bring to the detector from a
/// depolarising standard; δ is a parameter of the fit and not in it.
double polarization_response(PolarizationVector parameters, const StandardRow& row) {
  parameters(index_of(PolarizationParameter::detector_bias)) = 0;
  return source_vector(parameters, row.polarizer_deg)(0) *
         analyzer_vector(parameters, row.analyzer_deg)(0) /
         (ideal_source_vector(row.polarizer_deg)(0) * ideal_analyzer_vector(row.analyzer_deg)(0));
}

}  // namespace

std::vector<StandardRow> rows_of(const PreparedStandard& input, double wavelength,
                                 double phase_rad) {
  const formats::ScanTable& scan = input.standard->scan;
  const ReferenceStandard& reference = input.standard->reference;
  std::vector<StandardRow> rows;
  for (std::size_t i = 0; i < scan.size(); ++i) {
    if (input.set_up.row[i] != RowUse::plain || scan.saturated[i] != 0) continue;
    if (std::abs(scan.wavelength_nm[i] - wavelength) >= 0.5) continue;
    if (!reference.tabulated() &&
        std::abs(std::abs(scan.theta_i_deg[i]) - input.theta_i_deg) > 0.05)
      continue;
    const double cosine = std::cos(scan.theta_r_deg[i] * degree);
    if (!(cosine > 1e-3) || !(scan.monitor_v[i] > 0)) continue;
    const auto f = reference.brdf(scan.theta_i_deg[i], scan.theta_r_deg[i], scan.phi_r_deg[i],
                                  wavelength, scan.polarizer_deg[i], scan.analyzer_deg[i]);
    if (!f || !(*f > 0)) continue;
    const DarkLevel dark = input.dark.at(scan.gain[i]);
    const double true_part = 1.0 + input.ranges.at(scan.gain[i]).error;
    StandardRow row;
    row.signal_v = input.nonlinearity.true_signal(((scan.x_v[i] - dark.x_v) * std::cos(phase_rad) +
                                                   (scan.y_v[i] - dark.y_v) * std::sin(phase_rad)) /
                                                  true_part);
    row.stray_base = stray_base(input, i);
    row.phi_r_deg = scan.phi_r_deg[i];
    row.base = *f * cosine * input.solid_angle_sr * scan.monitor_v[i];
    row.theta_r_deg = scan.theta_r_deg[i];
    row.from_retro_deg =
        from_retro_deg(scan.theta_i_deg[i], scan.theta_r_deg[i], scan.phi_r_deg[i]);
    row.direction = scan.direction[i];
    row.log_slope_per_deg =
        reference.log_slope_per_deg(scan.theta_i_deg[i], scan.theta_r_deg[i], scan.phi_r_deg[i],
                                    wavelength, scan.polarizer_deg[i], scan.analyzer_deg[i]);
    row.gain = scan.gain[i];
    row.polarizer_deg = scan.polarizer_deg[i];
    row.analyzer_deg = scan.analyzer_deg[i];
    row.bias_lever = formats::is_open(scan.analyzer_deg[i]) ? polarisation(reference, scan, i)
                                                            : -cos_twice(scan.analyzer_deg[i]);
    row.retention_lever = reference.polarised()
                              ? 0.0
                              : cos_twice(scan.polarizer_deg[i]) * cos_twice(scan.analyzer_deg[i]);
    rows.push_back(row);
  }
  return rows;
}

void set_variances(std::vector<StandardRow>& rows, const PreparedStandard& input,
                   double wavelength) {
  std::vector<double> ratio;
  for (const StandardRow& row : rows) ratio.push_back(row.signal_v / row.base);
  if (ratio.empty()) return;
  const double middle = formats::median(std::move(ratio));
  for (StandardRow& row : rows) {
    const double true_part = 1.0 + input.ranges.at(row.gain).error;
    row.variance = input.noise.variance_normalised(wavelength, row.gain, middle * row.base) /
                   (true_part * true_part);
  }
}

void subtract_stray(std::vector<StandardRow>& rows, const StrayLight& stray, double wavelength) {
  if (stray.empty() || rows.empty()) return;
  std::vector<double> ratio;
  for (const StandardRow& row : rows) ratio.push_back(row.signal_v / row.base);
  const double gain_constant = formats::median(std::move(ratio));
  for (StandardRow& row : rows) {
    row.volts_per_stray = gain_constant * row.stray_base;
    row.signal_v -= row.volts_per_stray * stray.level(wavelength, row.theta_r_deg, row.phi_r_deg);
  }
}

void apply_polarization(std::vector<StandardRow>& rows, const PolarizationWavelength* entry) {
  if (entry == nullptr) return;
  for (StandardRow& row : rows) row.base *= polarization_response(entry->values(), row);
}

Eigen::MatrixXd polarization_shift(const std::vector<StandardRow>& rows, const StandardFit& fit,
                                   const PolarizationWavelength& entry, Eigen::Index parameters) {
  Eigen::MatrixXd shift = Eigen::MatrixXd::Zero(parameters, polarization_parameters);
  for (Eigen::Index k = 0; k < polarization_parameters; ++k) {
    constexpr double step = 1e-6;
    PolarizationVector up = entry.values(), down = up;
    up(k) += step;
    down(k) -= step;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const double slope = (std::log(polarization_response(up, rows[i])) -
                            std::log(polarization_response(down, rows[i]))) /
                           (2 * step);
      shift.col(k) -= slope * rows[i].signal_v *
                      fit.response.col(static_cast<Eigen::Index>(i)).head(parameters);
    }
  }
  return shift;
}

}  // namespace umov::calibrate
