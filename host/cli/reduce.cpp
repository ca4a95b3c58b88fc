// umov reduce: raw records to polarised BRDF, DOLP and DHR.
#include <filesystem>
#include <memory>
#include <string>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "host/calibrate/calibration_file.hpp"
#include "host/calibrate/reduce.hpp"
#include "host/calibrate/standard_file.hpp"
#include "host/cli/command.hpp"
#include "host/cli/output_file.hpp"
#include "host/errors/error.hpp"
#include "host/formats/brdf_h5.hpp"
#include "host/formats/scan_h5.hpp"
#include "host/formats/sha256.hpp"

namespace umov::cli {
namespace {

struct Options {
  std::string scan;
  std::string calibration;
  std::string output;
  calibrate::ReduceOptions reduce;
};

/// The calibration asked for; else the white scan that the scan names; else the scan's header keys.
calibrate::Calibration find_calibration(const Options& options, const formats::ScanTable& scan,
                                        std::string& origin) {
  if (!options.calibration.empty()) {
    origin = options.calibration;
    return calibrate::read_calibration(options.calibration);
  }
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

void print_text(const calibrate::Reduction& reduction, const std::string& origin,
                const std::string& output) {
  const auto& s = reduction.summary;
  fmt::print("calibration: {}\n", origin);
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
  for (const std::string& note : s.notes) fmt::print("note: {}\n", note);
  fmt::print("\n{} written\n", output);
}

nlohmann::json to_json(const calibrate::Reduction& reduction, const std::string& origin,
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
  return {{"file", output},
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
          {"dhr", dhr},
          {"factors", factors},
          {"notes", s.notes}};
}

void run(const Options& options, const Common& common) {
  require_product_output({options.scan, options.calibration}, options.output);
  const formats::ScanFile file = formats::read_scan(options.scan);
  std::string origin;
  const auto calibration = find_calibration(options, file.table, origin);
  calibrate::Reduction reduction = calibrate::reduce(file.table, calibration, options.reduce);
  auto& keys = reduction.table.keys;
  keys.emplace_back("scan_sha256", formats::sha256_of_file(options.scan));
  keys.emplace_back("calibration_origin", origin);
  if (!options.calibration.empty())
    keys.emplace_back("calibration_sha256", formats::sha256_of_file(options.calibration));
  formats::Provenance provenance = file.provenance;
  provenance.program = "umov " UMOV_VERSION;
  provenance.command = common.command_line;
  provenance.created.clear();
  formats::write_brdf_h5(options.output, reduction.table, provenance);
  if (common.json)
    fmt::print("{}\n", to_json(reduction, origin, options.output).dump());
  else if (!common.quiet)
    print_text(reduction, origin, options.output);
}

}  // namespace

void add_reduce_command(CLI::App& root, const Common& common) {
  auto options = std::make_shared<Options>();
  auto* command = root.add_subcommand("reduce", "Polarised BRDF, DOLP and DHR from a scan");
  command->add_option("scan", options->scan, "scan.h5 or Scan CSV")->required();
  command->add_option("--calibration", options->calibration,
                      "cal.h5; without it the white scan named by the key `reference`, else the "
                      "keys gain_constant_<nm> and solid_angle_sr");
  command->add_option("-o,--output", options->output, "file to write (brdf.h5)")->required();
  command->add_flag(
      "--extrapolate", options->reduce.extrapolate_instrument_function,
      "use exit angles beyond the standard's with the instrument function of its edge");
  command
      ->add_option("--normal-within-deg", options->reduce.normal_incidence_within_deg,
                   "incidence up to this counts as normal for the DHR")
      ->check(CLI::Range(0.0, 10.0))
      ->capture_default_str();
  command->footer(
      "Examples:\n"
      "  umov reduce scan.h5 --calibration cal.h5 -o brdf.h5\n"
      "  umov reduce scan.csv -o brdf.h5 --json");
  command->callback([options, &common] { run(*options, common); });
}

}  // namespace umov::cli
