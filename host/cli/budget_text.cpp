#include "host/cli/budget_text.hpp"

#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/formats/order_statistics.hpp"

namespace umov::cli {
namespace {

/// Median of the coverage factors of used points.
double middle_coverage(const std::vector<calibrate::PointBudget>& budget,
                       const calibrate::Reduction& reduction) {
  std::vector<double> k;
  for (const auto& point : budget)
    if (reduction.table.points.used[point.point] != 0) k.push_back(point.coverage_factor);
  return formats::median(std::move(k));
}

void print_budget(const PointQuality& quality, const calibrate::Reduction& reduction) {
  if (quality.budget.empty()) return;
  fmt::print("\nUncertainty budget, relative to the BRDF\n{:<34} {:>5} {:>12} {:>12}\n",
             "contribution", "type", "median [%]", "95 % [%]");
  for (const auto& share : calibrate::budget_shares(reduction, quality.budget))
    fmt::print("{:<34} {:>5} {:>12.3g} {:>12.3g}\n", share.name, share.type,
               100 * share.median_relative_u, 100 * share.high_relative_u);
  fmt::print("median coverage factor for 95 %: {:.2f}\n",
             middle_coverage(quality.budget, reduction));
}

void print_draws(const PointQuality& quality, const calibrate::Reduction& reduction) {
  if (!quality.draws) return;
  const auto& a = quality.agreement;
  fmt::print(
      "\nMonte Carlo, {} draws of records and calibration inputs through the whole chain{}\n"
      "u(draws)/u(budget): {:.3f} in the mean, {:.3f} to {:.3f} over {} points; {} beyond {:.0f} "
      "%: {}\n",
      quality.draws->draws,
      quality.draws->failed > 0 ? fmt::format(" ({} failed)", quality.draws->failed) : "",
      a.mean_ratio, a.smallest_ratio, a.largest_ratio, a.points, a.outside,
      100 * std::expm1(a.allowed_single),
      a.agrees ? "the propagation holds" : "THE PROPAGATION DOES NOT HOLD");
  const auto& dhr = reduction.table.dhr;
  for (std::size_t k = 0; k < quality.draws->dhr_u.size(); ++k)
    fmt::print("DHR {:g} nm: u {:.4f} by draws, {:.4f} by propagation and method\n",
               dhr.wavelength_nm[k], quality.draws->dhr_u[k], dhr.dhr_u[k]);
}

void print_reciprocity(const PointQuality& quality) {
  if (quality.reciprocity.empty()) return;
  const auto& all = quality.reciprocity.front();
  fmt::print(
      "\nreciprocity: {} pairs of exchanged directions within 60 deg, mean deviation {:+.2f} +- "
      "{:.2f} %, mean |deviation| {:.2f} %, rms {:.2f} % (expected {:.2f} %), largest {:.2f} %\n",
      all.pairs, 100 * all.mean, 100 * all.mean_u, 100 * all.mean_absolute, 100 * all.rms,
      100 * all.rms_expected, 100 * all.largest);
}

}  // namespace

void print_quality(const PointQuality& quality, const calibrate::Reduction& reduction) {
  print_reciprocity(quality);
  print_budget(quality, reduction);
  print_draws(quality, reduction);
}

void add_quality(const PointQuality& quality, const calibrate::Reduction& reduction,
                 nlohmann::json& out) {
  if (!quality.budget.empty()) {
    nlohmann::json shares = nlohmann::json::array();
    for (const auto& share : calibrate::budget_shares(reduction, quality.budget))
      shares.push_back({{"name", share.name},
                        {"type", std::string(1, share.type)},
                        {"median_relative_u", share.median_relative_u},
                        {"quantile_95_relative_u", share.high_relative_u}});
    out["budget"] = {{"contributions", shares},
                     {"median_coverage_factor", middle_coverage(quality.budget, reduction)}};
  }
  if (quality.draws) {
    const auto& a = quality.agreement;
    out["monte_carlo"] = {{"draws", quality.draws->draws},
                          {"failed", quality.draws->failed},
                          {"points", a.points},
                          {"mean_ratio", a.mean_ratio},
                          {"smallest_ratio", a.smallest_ratio},
                          {"largest_ratio", a.largest_ratio},
                          {"allowed_mean_log_ratio", a.allowed_mean},
                          {"allowed_log_ratio", a.allowed_single},
                          {"outside", a.outside},
                          {"agrees", a.agrees},
                          {"dhr_u", quality.draws->dhr_u}};
  }
  if (!quality.reciprocity.empty()) {
    const auto& all = quality.reciprocity.front();
    out["reciprocity"] = {{"pairs", all.pairs},     {"mean", all.mean},
                          {"mean_u", all.mean_u},   {"mean_absolute", all.mean_absolute},
                          {"rms", all.rms},         {"rms_expected", all.rms_expected},
                          {"largest", all.largest}, {"chi2", all.chi2}};
  }
}

}  // namespace umov::cli
