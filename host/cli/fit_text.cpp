#include "host/cli/fit_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace umov::cli {
namespace {

/// Decimal places that the interval justifies: two digits of the half width.
int decimal_places(double lo, double hi) {
  const double half = 0.5 * (hi - lo);
  return half > 0 ? 1 - static_cast<int>(std::floor(std::log10(half))) : 6;
}

/// `value` rounded to decimal places (negative: tens, hundreds …), or in powers of ten where that
/// would be long. Numbers of one interval get the same places, so that rounding, which keeps the
/// order, cannot put a value outside of its limits.
std::string rounded_text(double value, int places) {
  if (!std::isfinite(value)) return fmt::format("{}", value);
  if (places >= 0 && places <= 7 && std::abs(value) < 1e7) {
    std::string text = fmt::format("{:.{}f}", value, places);
    const bool zero = text.find_first_of("123456789") == std::string::npos;
    return zero && text.front() == '-' ? text.substr(1) : text;
  }
  const double unit = std::pow(10.0, places);
  const double rounded = std::round(value * unit) / unit;
  if (rounded == 0) return "0";
  const int digits = static_cast<int>(std::floor(std::log10(std::abs(rounded)) + 1e-9)) + places;
  return fmt::format("{:.{}g}", rounded, std::clamp(digits + 1, 1, 15));
}

std::string value_text(const formats::Estimate& e) {
  if (!(e.hi > e.lo)) return fmt::format("{:.6g}", e.value);
  return rounded_text(e.value, decimal_places(e.lo, e.hi));
}

std::string interval_text(const formats::Estimate& e, bool fixed) {
  if (fixed) return "fixed";
  const double half = 0.5 * (e.hi - e.lo);
  const bool symmetric = std::abs(e.hi + e.lo - 2 * e.value) < 0.1 * (e.hi - e.lo);
  if (symmetric && e.at_bound.empty()) return fmt::format("± {:.2g}", half);
  if (!(e.hi > e.lo)) return fmt::format("{:.6g} … {:.6g}", e.lo, e.hi);
  const int places = decimal_places(e.lo, e.hi);
  return rounded_text(e.lo, places) + " … " + rounded_text(e.hi, places);
}

void print_parameters(const formats::FitResult& fit,
                      const std::vector<formats::FitParameter>& parameters) {
  for (const formats::FitParameter& p : parameters) {
    for (std::size_t w = 0; w < p.estimates.size(); ++w) {
      const formats::Estimate& e = p.estimates[w];
      std::string remark;
      if (!e.at_bound.empty()) {
        remark = "  at its " + e.at_bound + " limit";
      } else if (!e.identifiable) {
        remark = "  not determined alone";
      }
      fmt::print("  {:<24} {:>8}  {:>12}  {:<20} {}{}\n", w == 0 ? p.name : "",
                 p.shared ? "all" : fmt::format("{:g}", fit.wavelengths_nm[w]), value_text(e),
                 interval_text(e, p.fixed), p.unit == "1" ? "" : p.unit, remark);
    }
  }
}

}  // namespace

void print_fit(const formats::FitResult& fit, const std::string& output) {
  fmt::print("{}: {} to {} points at", output, fit.model, fit.points);
  for (const double nm : fit.wavelengths_nm) fmt::print(" {:g}", nm);
  fmt::print(" nm\n  {:<24} {:>8}  {:>12}  {:<20}\n", "parameter", "nm", "value", "95 %");
  print_parameters(fit, fit.parameters);
  if (!fit.derived.empty()) fmt::print("derived\n");
  print_parameters(fit, fit.derived);
  if (!fit.dhr.empty()) {
    fmt::print("directional-hemispherical reflectance\n  {:>6} {:>8}  {:>8}  95 %\n", "nm",
               "theta_i", "value");
    for (const auto& d : fit.dhr) {
      const int places = std::max(decimal_places(d.lo, d.hi), 5);
      fmt::print("  {:>6g} {:>8g}  {:>8}  {} … {}\n", d.wavelength_nm, d.theta_i_deg,
                 rounded_text(d.value, places), rounded_text(d.lo, places),
                 rounded_text(d.hi, places));
    }
  }
  const bool calibration = std::any_of(fit.factors.begin(), fit.factors.end(),
                                       [](const auto& f) { return std::abs(f.value) > 1; });
  if (calibration) {
    fmt::print("calibration moved by more than one standard deviation\n");
    for (const auto& f : fit.factors) {
      if (std::abs(f.value) > 1) {
        fmt::print("  {:<32} {:+.2f} ± {:.2f}\n", f.name, f.value, f.standard_error);
      }
    }
  }
  if (!fit.priors.empty()) fmt::print("prior knowledge\n");
  for (const std::string& prior : fit.priors) fmt::print("  {}\n", prior);
  if (!fit.identifiability.empty()) fmt::print("identifiability\n");
  for (const std::string& sentence : fit.identifiability) fmt::print("  {}\n", sentence);
  if (!fit.notes.empty()) fmt::print("notes\n");
  for (const std::string& note : fit.notes) fmt::print("  {}\n", note);
  fmt::print(
      "chi2/dof {:.4g} ({} objective {:.6g}), held-out gap {}, {} iterations, {} of {} starts "
      "agree, {:.2f} s\n",
      fit.chi2 / static_cast<double>(fit.dof), fit.objective_kind, fit.objective,
      fit.g2_held_out ? fmt::format("{:+.3f}", *fit.g2_held_out) : "none", fit.iterations,
      fit.starts_agreeing, fit.starts, fit.seconds);
}

void print_prediction(const std::vector<invert::PredictionError>& errors) {
  if (errors.empty()) return;
  fmt::print("relative error of the model (median and 90th percentile of its size, signed mean)\n");
  for (const auto& e : errors) {
    fmt::print("  {:<9} {:>6g} nm {:>7} points  {:>6.2f} %  {:>6.2f} %  {:>+6.2f} %\n", e.set,
               e.wavelength_nm, e.points, 100 * e.median_abs, 100 * e.p90_abs, 100 * e.mean);
  }
}

}  // namespace umov::cli
