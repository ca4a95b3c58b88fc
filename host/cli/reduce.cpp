// umov reduce: raw records to polarised BRDF, DOLP and DHR.
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "host/calibrate/calibration_file.hpp"
#include "host/calibrate/campaign.hpp"
#include "host/calibrate/reduce.hpp"
#include "host/calibrate/standard_file.hpp"
#include "host/cli/budget_text.hpp"
#include "host/cli/command.hpp"
#include "host/cli/interrupt.hpp"
#include "host/cli/output_file.hpp"
#include "host/cli/progress.hpp"
#include "host/errors/error.hpp"
#include "host/formats/brdf_h5.hpp"
#include "host/formats/fit_file.hpp"
#include "host/formats/scan_h5.hpp"
#include "host/formats/sha256.hpp"
#include "host/invert/prediction.hpp"

namespace umov::cli {
namespace {

struct Options {
  std::string scan;
  std::string calibration;
  std::string campaign;
  std::string output;
  std::string budget;
  std::vector<std::string> guides;
  std::size_t draws = 0;
  calibrate::ReduceOptions reduce;
};

/// Elements over m00 with their uncertainties, a direction a line.
void print_mueller(const formats::BrdfTable::Mueller& m) {
  fmt::print("\n{:>7} {:>7} {:>7} {:>6} {:>10}", "nm", "theta_i", "theta_r", "phi_r", "m00 [1/sr]");
  for (const char* name : {"m01", "m02", "m10", "m11", "m12", "m20", "m21", "m22"})
    fmt::print(" {:>14}", fmt::format("{}/m00", name));
  fmt::print(" {:>9}\n", "real. z");
  for (std::size_t n = 0; n < m.size(); ++n) {
    const double* value = &m.mueller[n * m.elements()];
    const double* u = &m.mueller_u[n * m.elements()];
    fmt::print("{:>7g} {:>7g} {:>7g} {:>6g} {:>10.4g}", m.wavelength_nm[n], m.theta_i_deg[n],
               m.theta_r_deg[n], m.phi_r_deg[n], value[0]);
    for (std::size_t k = 1; k < 9; ++k)
      fmt::print(" {:>14}", std::isnan(value[k])
                                ? std::string("-")
                                : fmt::format("{:.4f}+-{:.4f}", value[k] / value[0],
                                              u[k] / std::abs(value[0])));
    fmt::print(" {:>9}\n",
               std::isnan(m.realisable_z[n]) ? "-" : fmt::format("{:.1f}", m.realisable_z[n]));
  }
}

/// The calibration asked for; else the white scan that the scan names; else the scan's header keys.
calibrate::Calibration find_calibration(const Options& options, const formats::ScanTable& scan,
                                        std::string& origin) {
  if (!options.calibration.empty()) {
    origin = options.calibration;
    return calibrate::read_calibration(options.calibration);
  }
  if (scan.size() == 0) throw Error(Place{options.scan}, "has no records", "measure again");
  if (const auto reference = scan.key("reference")) {
    std::filesystem::path file = *reference;
    if (!file.is_absolute() && !std::filesystem::exists(file))
      file = std::filesystem::path(options.scan).parent_path() / file;
    if (std::filesystem::exists(file)) {
      origin = file.string() + " (key `reference` of the scan)";
      const auto standard = calibrate::read_standard(file);
      return calibrate::calibrate(std::span(&standard, 1));
    }
    if (!scan.number(fmt::format("gain_constant_{:g}", scan.wavelength_nm.front())))
      throw Error(Place{options.scan},
                  fmt::format("the white scan `{}` that the key `reference` names is not there",
                              *reference),
                  "put it beside the scan, or give --calibration FILE");
  }
  origin = "header keys of the scan";
  return calibrate::calibration_from_header(scan);
}

void print_text(const calibrate::Reduction& reduction, const calibrate::Alignment& alignment,
                const PointQuality& quality, const std::string& origin, const std::string& output) {
  const auto& s = reduction.summary;
  fmt::print("calibration: {}\n", origin);
  if (alignment.theta_i_deg() != 0 || alignment.theta_r_deg() != 0)
    fmt::print(
        "angles of the fits: theta_i {:+.4f} deg, theta_r {:+.4f} deg beside the commanded ones\n",
        alignment.theta_i_deg(), alignment.theta_r_deg());
  fmt::print("{} records: {} points, {} left out (changed set-up or shutter closed)\n", s.records,
             s.points, s.excluded);
  fmt::print(
      "flagged: {} saturated, {} beyond the standard's exit angles, {} in the detector's shadow; "
      "used though below the noise: {}\n",
      s.saturated, s.outside_instrument_function, s.in_shadow, s.below_noise);
  fmt::print("median relative u: {:.3g} % noise, {:.3g} % with {} shared factors\n",
             100 * s.median_relative_u, 100 * s.median_relative_total_u,
             reduction.table.factors.size());
  fmt::print("DOLP: {} values\n", s.dolp);
  const auto& mueller = s.mueller;
  if (mueller.directions > 0)
    fmt::print(
        "Mueller: {} directions, {} with all nine linear elements (condition up to {:.3g}), "
        "chi2/dof {}, {} unphysical by more than three standard errors\n",
        mueller.directions, mueller.complete, mueller.largest_condition,
        mueller.dof > 0 ? fmt::format("{:.2f}", mueller.chi2 / mueller.dof) : "-",
        mueller.unphysical);
  const auto& dhr = reduction.table.dhr;
  if (!dhr.dhr.empty())
    fmt::print("\n{:>7} {:>12} {:>8} {:>8}\n", "nm", "theta_i [deg]", "DHR", "u");
  for (std::size_t k = 0; k < dhr.dhr.size(); ++k)
    fmt::print("{:>7g} {:>12g} {:>8.4f} {:>8.4f}\n", dhr.wavelength_nm[k], dhr.theta_i_deg[k],
               dhr.dhr[k], dhr.dhr_u[k]);
  if (dhr.dhr.empty())
    fmt::print(
        "DHR: none (needs an in-plane scan at normal incidence; `umov invert` gives it "
        "otherwise)\n");
  print_quality(quality, reduction);
  for (const std::string& note : s.notes) fmt::print("note: {}\n", note);
  fmt::print("\n{} written\n", output);
}

nlohmann::json to_json(const calibrate::Reduction& reduction, const calibrate::Alignment& alignment,
                       const PointQuality& quality, const std::string& origin,
                       const std::string& output) {
  const auto& s = reduction.summary;
  nlohmann::json factors = nlohmann::json::array(), dhr = nlohmann::json::array();
  for (const auto& factor : reduction.table.factors) factors.push_back(factor.name);
  const auto& d = reduction.table.dhr;
  for (std::size_t k = 0; k < d.dhr.size(); ++k)
    dhr.push_back({{"wavelength_nm", d.wavelength_nm[k]},
                   {"theta_i_deg", d.theta_i_deg[k]},
                   {"dhr", d.dhr[k]},
                   {"dhr_u", d.dhr_u[k]}});
  nlohmann::json out{
      {"file", output},
      {"calibration", origin},
      {"records", s.records},
      {"points", s.points},
      {"excluded", s.excluded},
      {"saturated", s.saturated},
      {"outside_instrument_function", s.outside_instrument_function},
      {"in_shadow", s.in_shadow},
      {"below_noise", s.below_noise},
      {"median_relative_u", s.median_relative_u},
      {"median_relative_total_u", s.median_relative_total_u},
      {"dolp", s.dolp},
      {"mueller",
       {{"directions", s.mueller.directions},
        {"complete", s.mueller.complete},
        {"left_out", s.mueller.left_out},
        {"unphysical", s.mueller.unphysical},
        {"chi2", s.mueller.chi2},
        {"degrees_of_freedom", s.mueller.dof},
        {"largest_condition", s.mueller.largest_condition},
        {"undetermined", s.mueller.undetermined}}},
      {"dhr", dhr},
      {"angles",
       {{"theta_i_deg", alignment.theta_i_deg()}, {"theta_r_deg", alignment.theta_r_deg()}}},
      {"factors", factors},
      {"notes", s.notes}};
  add_quality(quality, reduction, out);
  return out;
}

/// A campaign evaluated for this reduction, with the scans it rests on.
struct EvaluatedCampaign {
  calibrate::CampaignOptions options;
  std::vector<calibrate::CampaignScan> scans;
  calibrate::Campaign result;
};

EvaluatedCampaign evaluate(const std::string& file) {
  EvaluatedCampaign campaign;
  campaign.options = calibrate::read_campaign(file);
  campaign.scans = calibrate::read_campaign_scans(campaign.options);
  campaign.result = calibrate::evaluate_campaign(campaign.scans, campaign.options);
  return campaign;
}

/// What fits of earlier reductions of this scan tell: each the angles that were still off, the last
/// one the BRDF's course between the points.
void take_guidance(const std::vector<std::string>& files, const formats::ScanTable& scan,
                   const calibrate::Calibration& calibration, calibrate::ReduceOptions& options) {
  for (const std::string& file : files) {
    const formats::FitResult fit = formats::read_fit(file);
    for (const double nm : calibrate::wavelengths_of(scan))
      if (!fit.wavelength_index(nm))
        throw Error(Place{file},
                    fmt::format("has no model at {:g} nm, where the scan was taken", nm),
                    "guide by a fit of this scan");
    options.alignment += calibrate::alignment_found(fit, calibration.declared);
    options.shape = invert::brdf_function(fit);
  }
}

/// Draws the whole chain again and again and lays the scatter beside the propagation.
void check_by_draws(const Options& options, const Common& common, const formats::ScanTable& scan,
                    const EvaluatedCampaign& campaign,
                    const calibrate::ReduceOptions& reduce_options,
                    const calibrate::Reduction& reduction, PointQuality& quality) {
  catch_interrupts();
  Progress progress("Monte Carlo", common.quiet);
  calibrate::MonteCarloOptions draws;
  draws.draws = options.draws;
  draws.seed = common.seed;
  draws.threads = common.threads;
  draws.progress = [&](std::size_t done, std::size_t total) {
    progress.update(static_cast<double>(done), static_cast<double>(total));
    return !interrupt_flag().load();
  };
  const calibrate::CampaignScan reduced{scan, options.scan, scan.key("sample").value_or(""),
                                        scan.key("role").value_or(""),
                                        formats::sha256_of_file(options.scan)};
  quality.draws = calibrate::monte_carlo(campaign.scans, campaign.options, campaign.result, reduced,
                                         reduction, reduce_options, draws);
  progress.finish();
  std::vector<double> propagated;
  for (const auto& point : quality.budget) propagated.push_back(point.combined_u);
  quality.agreement =
      calibrate::compare_with_draws(*quality.draws, propagated, reduction.table.points.used);
}

void run(const Options& options, const Common& common) {
  std::vector<std::string> inputs = {options.scan, options.calibration, options.campaign};
  inputs.insert(inputs.end(), options.guides.begin(), options.guides.end());
  require_product_output(inputs, options.output);
  inputs.push_back(options.output);
  if (!options.budget.empty()) require_product_output(inputs, options.budget);
  if (options.draws > 0 && options.campaign.empty())
    throw Error("a Monte Carlo check needs the scans that the calibration was made of",
                "give --campaign campaign.toml instead of --calibration");
  const formats::ScanFile file = formats::read_scan(options.scan);
  std::string origin = options.campaign;
  std::optional<EvaluatedCampaign> campaign;
  if (!options.campaign.empty()) campaign = evaluate(options.campaign);
  const auto calibration =
      campaign ? campaign->result.calibration : find_calibration(options, file.table, origin);
  calibrate::ReduceOptions how = options.reduce;
  take_guidance(options.guides, file.table, calibration, how);
  calibrate::Reduction reduction = calibrate::reduce(file.table, calibration, how);
  PointQuality quality;
  quality.reciprocity = calibrate::check_reciprocity(reduction.table);
  if (!options.budget.empty() || options.draws > 0)
    quality.budget = calibrate::budget_of(reduction, calibration);
  if (options.draws > 0)
    check_by_draws(options, common, file.table, *campaign, how, reduction, quality);
  if (!options.budget.empty())
    calibrate::write_budget(options.budget, reduction, quality.budget,
                            quality.draws ? quality.draws->u_per_sr : std::vector<double>{});
  auto& keys = reduction.table.keys;
  keys.emplace_back("scan_sha256", formats::sha256_of_file(options.scan));
  keys.emplace_back("calibration_origin", origin);
  if (!options.calibration.empty())
    keys.emplace_back("calibration_sha256", formats::sha256_of_file(options.calibration));
  for (const std::string& guide : options.guides)
    keys.emplace_back("guide_sha256", formats::sha256_of_file(guide));
  formats::Provenance provenance = file.provenance;
  provenance.program = "umov " UMOV_VERSION;
  provenance.command = common.command_line;
  provenance.created.clear();
  formats::write_brdf_h5(options.output, reduction.table, provenance);
  if (common.json)
    fmt::print("{}\n", to_json(reduction, how.alignment, quality, origin, options.output).dump());
  else if (!common.quiet)
    print_text(reduction, how.alignment, quality, origin, options.output);
  if (!common.json && !common.quiet && options.reduce.mueller_partial && reduction.table.mueller)
    print_mueller(*reduction.table.mueller);
}

}  // namespace

void add_reduce_command(CLI::App& root, const Common& common) {
  auto options = std::make_shared<Options>();
  auto* command = root.add_subcommand("reduce", "Polarised BRDF, DOLP and DHR from a scan");
  command->add_option("scan", options->scan, "scan.h5 or Scan CSV")->required();
  command->add_option("--calibration", options->calibration,
                      "cal.h5; without it the white scan named by the key `reference`, else the "
                      "keys gain_constant_<nm> and solid_angle_sr");
  command
      ->add_option("--campaign", options->campaign,
                   "campaign.toml: its calibration is evaluated now instead of read from cal.h5")
      ->excludes("--calibration");
  command->add_option("-o,--output", options->output, "file to write (brdf.h5)")->required();
  command->add_option("--budget", options->budget,
                      "uncertainty budget of every point to write (.csv, or .json)");
  command
      ->add_option("--monte-carlo", options->draws,
                   "check the uncertainties by so many draws through the whole chain (some "
                   "hundreds; needs --campaign)")
      ->check(CLI::Range(10, 1000000));
  command->add_option("--guided-by", options->guides,
                      "fit.json of an earlier reduction of this scan, in their order where there "
                      "were several: puts "
                      "the points at the angles that its lobes showed (of doubts declared in the "
                      "campaign), and its "
                      "model tells how the BRDF runs between them");
  command->add_flag(
      "--extrapolate", options->reduce.extrapolate_instrument_function,
      "use exit angles beyond the standard's with the instrument function of its edge");
  command
      ->add_option("--normal-within-deg", options->reduce.normal_incidence_within_deg,
                   "incidence up to this counts as normal for the DHR")
      ->check(CLI::Range(0.0, 10.0))
      ->capture_default_str();
  command->add_flag("--mueller", options->reduce.mueller_partial,
                    "print the Mueller elements of every direction, and keep the four that P and S "
                    "states give where there are no oblique ones");
  command->footer(
      "Examples:\n"
      "  umov reduce scan.h5 --calibration cal.h5 -o brdf.h5\n"
      "  umov reduce scan.csv -o brdf.h5 --json\n"
      "  umov reduce scan.h5 --calibration cal.h5 -o brdf.h5 --budget budget.csv\n"
      "  umov reduce scan.h5 --campaign campaign.toml -o brdf.h5 --monte-carlo 400\n"
      "  umov reduce scan.h5 --calibration cal.h5 -o better.h5 --guided-by fit.json");
  command->callback([options, &common] { run(*options, common); });
}

}  // namespace umov::cli
