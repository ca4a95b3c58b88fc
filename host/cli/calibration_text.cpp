#include "host/cli/calibration_text.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/calibrate/published_reflectance.hpp"
#include "host/cli/polarization_text.hpp"
#include "host/optics/angles.hpp"

namespace umov::cli {
namespace {

using calibrate::Calibration;

struct Spread {
  double low = 1, high = 1;
};

Spread spread_of(const calibrate::InstrumentFunction& function) {
  Spread spread{std::numeric_limits<double>::infinity(), 0};
  for (double t = function.min_deg; t <= function.max_deg; t += 0.5) {
    spread.low = std::min(spread.low, function.value(t));
    spread.high = std::max(spread.high, function.value(t));
  }
  return spread;
}

/// The published figures that a check is laid beside.
std::optional<calibrate::PublishedReflectance> published_of(const calibrate::StandardCheck& check,
                                                            const CalibrationView& view) {
  for (const auto& [name, row] : view.compare)
    if (name == check.standard) return calibrate::published_reflectance(row, check.wavelength_nm);
  return std::nullopt;
}

/// Mean |computed/stated - 1| over the checks that have a stated value; NaN where none has.
double mean_check_error(const Calibration& calibration) {
  double sum = 0;
  int count = 0;
  for (const auto& check : calibration.checks) {
    if (std::isnan(check.stated)) continue;
    sum += std::abs(check.computed / check.stated - 1);
    ++count;
  }
  return count > 0 ? sum / count : std::numeric_limits<double>::quiet_NaN();
}

void print_gains(const Calibration& calibration) {
  fmt::print("{:>7} {:>11} {:>8} {:>8} {:>17} {:>13} {:>12} {:>9}\n", "nm", "C [V]", "u noise",
             "u ref.", "IF", "theta_r [deg]", "phase [deg]", "chi2/dof");
  for (const auto& w : calibration.wavelengths) {
    const Spread spread = spread_of(w.instrument_function);
    fmt::print(
        "{:>7g} {:>11.4f} {:>7.2g}% {:>7.2g}% {:>8.4f}-{:<8.4f} {:>6g}..{:<5g} {:>12.4f} "
        "{:>9.2f}\n",
        w.wavelength_nm, w.gain_constant_v, 100 * std::sqrt(w.covariance(0, 0)),
        100 * w.reference_relative_u, spread.low, spread.high, w.instrument_function.min_deg,
        w.instrument_function.max_deg, optics::degrees(w.phase_rad),
        w.dof > 0 ? w.chi2 / w.dof : 0.0);
    if (w.bias_active)
      fmt::print("        detector polarisation bias {:+.4f} +- {:.4f} is applied\n",
                 w.detector_bias, w.detector_bias_u);
  }
}

void print_checks(const Calibration& calibration, const CalibrationView& view) {
  if (calibration.checks.empty()) return;
  fmt::print("\nDHR of the standards\n{:<20} {:>7} {:>8} {:>17} {:>8}{}\n", "standard", "nm",
             "stated", "computed", "diff.",
             view.compare.empty() ? "" : "   published: maker/photometer/BRDF");
  for (const auto& check : calibration.checks) {
    const auto published = published_of(check, view);
    fmt::print("{:<20} {:>7g} {:>8} {:>8.4f} +-{:>6.4f} {:>8}{}{}\n", check.standard,
               check.wavelength_nm,
               std::isnan(check.stated) ? "-" : fmt::format("{:.4f}", check.stated), check.computed,
               check.computed_u,
               std::isnan(check.stated)
                   ? "-"
                   : fmt::format("{:+.2f}%", 100 * (check.computed / check.stated - 1)),
               published ? fmt::format("   {:.3f}/{:.3f}/{:.3f}", published->maker,
                                       published->spectrophotometer, published->computed)
                         : "",
               check.used_for_gain ? "  (fixes the gain)" : "");
  }
  if (const double mean = mean_check_error(calibration); !std::isnan(mean))
    fmt::print("mean |computed/stated - 1| over {} values: {:.2f} %\n", calibration.checks.size(),
               100 * mean);
}

void print_ranges(const Calibration& calibration) {
  fmt::print("\nAmplifier ranges and dark signal\n{:>7} {:>12} {:>10} {:>13} {:>12}\n", "range",
             "error", "u", "dark x [V]", "u [V]");
  for (const auto& range : calibration.ranges.ranges) {
    const auto level = calibration.dark.at(range.gain);
    fmt::print("{:>7g} {:>12.3g} {:>10.2g} {:>13.3g} {:>12.2g}{}{}\n", range.gain, range.error,
               range.u, level.x_v, level.x_u, range.measured ? "" : "  nominal ratio",
               level.records > 0 ? "" : "  dark not measured");
  }
}

void print_linearity(const Calibration& calibration, const CalibrationView& view) {
  const auto& law = calibration.nonlinearity;
  fmt::print(
      "\nLinearity, S/(1 + kappa S): kappa = {:+.2g} +- {:.2g} /V, {} ({} records up to {:.3g} V, "
      "slow scatter {:.2g} %)\n",
      law.kappa_per_v, law.kappa_u_per_v, law.measured ? "measured" : "assumed for the most part",
      law.records, law.strongest_v, 100 * view.slow_noise);
}

void print_stray_light(const Calibration& calibration) {
  const auto& stray = calibration.stray;
  if (stray.empty()) return;
  fmt::print(
      "\nStray light as BRDF cos(theta_r), L + F exp(-a2/2w2) about forward grazing, w = "
      "{:g} deg\n{:>7} {:>22} {:>22}\n",
      stray.forward_width_deg, "nm", "L [1/sr]", "F [1/sr]");
  const auto count = static_cast<Eigen::Index>(stray.wavelength_nm.size());
  for (Eigen::Index w = 0; w < count; ++w) {
    const auto at = static_cast<std::size_t>(w);
    fmt::print("{:>7g} {:>11.3g} +- {:>7.2g} {:>11.3g} +- {:>7.2g}{}\n", stray.wavelength_nm[at],
               stray.even_per_sr[at], std::sqrt(stray.covariance(w, w)), stray.forward_per_sr[at],
               std::sqrt(stray.covariance(count + w, count + w)),
               stray.measured[at] != 0 ? "" : "  assumed");
  }
}

void print_reciprocity(const Calibration& calibration, const CalibrationView& view) {
  if (calibration.reciprocity.empty()) return;
  fmt::print("\nReciprocity of {}\n{:>7} {:>6} {:>18} {:>8} {:>8} {:>10} {:>17} {:>10}\n",
             calibration.reciprocity.front().sample, "nm", "pairs", "mean [%]", "mean |.|", "rms",
             "rms expct.", "largest at i, r", "chi2/pairs");
  for (const auto& r : calibration.reciprocity)
    fmt::print(
        "{:>7} {:>6} {:>+8.3f} +- {:>6.3f} {:>8.3f} {:>8.3f} {:>10.3f} {:>8.2f} {:>3g},{:>4g} "
        "{:>10.2f}\n",
        r.wavelength_nm > 0 ? fmt::format("{:g}", r.wavelength_nm) : "all", r.pairs, 100 * r.mean,
        100 * r.mean_u, 100 * r.mean_absolute, 100 * r.rms, 100 * r.rms_expected, 100 * r.largest,
        r.largest_theta_i_deg, r.largest_theta_r_deg, r.chi2 / static_cast<double>(r.pairs));
  const bool passed = calibration.reciprocity.front().mean_absolute <= view.reciprocity_target;
  fmt::print("mean |deviation| {} the target of {:g} %\n", passed ? "meets" : "MISSES",
             100 * view.reciprocity_target);
}

nlohmann::json number(double value) {
  return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json(nullptr);
}

void add_campaign(const Calibration& calibration, const CalibrationView& view,
                  nlohmann::json& out) {
  const auto& law = calibration.nonlinearity;
  out["linearity"] = {{"kappa_per_v", law.kappa_per_v}, {"kappa_u_per_v", law.kappa_u_per_v},
                      {"measured", law.measured},       {"records", law.records},
                      {"strongest_v", law.strongest_v}, {"degrees_of_freedom", law.dof},
                      {"slow_noise", view.slow_noise}};
  const auto& stray = calibration.stray;
  nlohmann::json levels = nlohmann::json::array();
  const auto count = static_cast<Eigen::Index>(stray.wavelength_nm.size());
  for (Eigen::Index w = 0; w < count; ++w) {
    const auto at = static_cast<std::size_t>(w);
    levels.push_back({{"wavelength_nm", stray.wavelength_nm[at]},
                      {"even_per_sr", stray.even_per_sr[at]},
                      {"even_u_per_sr", std::sqrt(stray.covariance(w, w))},
                      {"forward_per_sr", stray.forward_per_sr[at]},
                      {"forward_u_per_sr", std::sqrt(stray.covariance(count + w, count + w))},
                      {"measured", stray.measured[at] != 0}});
  }
  out["stray_light"] = {{"forward_width_deg", stray.forward_width_deg},
                        {"records", stray.records},
                        {"levels", levels}};
  nlohmann::json reciprocity = nlohmann::json::array();
  for (const auto& r : calibration.reciprocity)
    reciprocity.push_back({{"sample", r.sample},
                           {"wavelength_nm", r.wavelength_nm > 0 ? nlohmann::json(r.wavelength_nm)
                                                                 : nlohmann::json(nullptr)},
                           {"pairs", r.pairs},
                           {"mean", r.mean},
                           {"mean_u", r.mean_u},
                           {"mean_absolute", r.mean_absolute},
                           {"rms", r.rms},
                           {"rms_expected", r.rms_expected},
                           {"largest", r.largest},
                           {"largest_theta_i_deg", r.largest_theta_i_deg},
                           {"largest_theta_r_deg", r.largest_theta_r_deg},
                           {"chi2", r.chi2}});
  out["reciprocity"] = reciprocity;
  out["reciprocity_target"] = view.reciprocity_target;
  out["not_calibrated"] = view.missing;
}

nlohmann::json calibration_to_json(const Calibration& calibration, const CalibrationView& view,
                                   const std::string& file) {
  nlohmann::json out{{"file", file},
                     {"solid_angle_sr", calibration.solid_angle_sr},
                     {"retro_shadow_deg", calibration.retro_shadow_deg},
                     {"wavelengths", nlohmann::json::array()},
                     {"checks", nlohmann::json::array()},
                     {"ranges", nlohmann::json::array()},
                     {"inputs", nlohmann::json::array()},
                     {"notes", calibration.notes}};
  for (const auto& w : calibration.wavelengths) {
    const Spread spread = spread_of(w.instrument_function);
    out["wavelengths"].push_back({{"wavelength_nm", w.wavelength_nm},
                                  {"gain_constant_v", w.gain_constant_v},
                                  {"gain_constant_relative_u", std::sqrt(w.covariance(0, 0))},
                                  {"reference_relative_u", w.reference_relative_u},
                                  {"instrument_function",
                                   {{"min", spread.low},
                                    {"max", spread.high},
                                    {"theta_r_min_deg", w.instrument_function.min_deg},
                                    {"theta_r_max_deg", w.instrument_function.max_deg},
                                    {"legendre_degrees", w.instrument_function.degrees},
                                    {"coefficients", w.instrument_function.coefficients}}},
                                  {"phase_deg", optics::degrees(w.phase_rad)},
                                  {"phase_u_deg", optics::degrees(w.phase_u_rad)},
                                  {"detector_bias", w.detector_bias},
                                  {"detector_bias_u", w.detector_bias_u},
                                  {"detector_bias_applied", w.bias_active},
                                  {"records", w.records},
                                  {"rejected", w.rejected},
                                  {"chi2", w.chi2},
                                  {"degrees_of_freedom", w.dof}});
  }
  for (const auto& check : calibration.checks) {
    nlohmann::json entry{{"standard", check.standard},     {"wavelength_nm", check.wavelength_nm},
                         {"stated", number(check.stated)}, {"computed", check.computed},
                         {"computed_u", check.computed_u}, {"used_for_gain", check.used_for_gain}};
    if (const auto published = published_of(check, view))
      entry["published"] = {{"maker", published->maker},
                            {"spectrophotometer", published->spectrophotometer},
                            {"computed", published->computed}};
    out["checks"].push_back(std::move(entry));
  }
  out["mean_check_error"] = number(mean_check_error(calibration));
  for (const auto& range : calibration.ranges.ranges) {
    const auto level = calibration.dark.at(range.gain);
    out["ranges"].push_back({{"gain", range.gain},
                             {"error", range.error},
                             {"u", range.u},
                             {"measured", range.measured},
                             {"dark_x_v", level.x_v},
                             {"dark_x_u_v", level.x_u},
                             {"dark_measured", level.records > 0}});
  }
  if (calibration.polarization) out["polarization"] = polarization_json(*calibration.polarization);
  for (const auto& input : calibration.inputs)
    out["inputs"].push_back({{"name", input.name}, {"role", input.role}, {"sha256", input.sha256}});
  if (view.campaign) add_campaign(calibration, view, out);
  return out;
}

}  // namespace

void print_calibration(const Calibration& calibration, const CalibrationView& view) {
  print_gains(calibration);
  print_checks(calibration, view);
  if (calibration.polarization) fmt::print("\n{}", polarization_text(*calibration.polarization));
  print_ranges(calibration);
  if (!view.campaign) return;
  print_linearity(calibration, view);
  print_stray_light(calibration);
  print_reciprocity(calibration, view);
}

std::string calibration_json(const Calibration& calibration, const CalibrationView& view,
                             const std::string& file) {
  return calibration_to_json(calibration, view, file).dump();
}

}  // namespace umov::cli
