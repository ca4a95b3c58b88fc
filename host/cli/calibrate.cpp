// umov calibrate: gain, instrument function, dark and phase from scans of standards.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "host/calibrate/calibration.hpp"
#include "host/calibrate/calibration_file.hpp"
#include "host/calibrate/standard_file.hpp"
#include "host/cli/command.hpp"
#include "host/cli/output_file.hpp"
#include "host/errors/error.hpp"
#include "host/formats/scan_h5.hpp"
#include "host/formats/sha256.hpp"
#include "host/optics/angles.hpp"

namespace umov::cli {
namespace {

struct Options {
  std::vector<std::string> files;
  std::string output;
  std::string standard;
  std::string reference_brdf;
  std::string bias = "auto";
  int max_degree = 8;
  double range_tolerance = 1e-3;
};

struct Inputs {
  std::vector<calibrate::StandardScan> standards;
  std::vector<formats::ScanTable> dark;
  std::vector<calibrate::CalibrationInput> others;  ///< dark and mirror scans
  std::vector<std::string> notes;
};

Inputs read_inputs(const Options& options) {
  Inputs inputs;
  const std::optional<std::filesystem::path> table =
      options.reference_brdf.empty() ? std::nullopt
                                     : std::optional<std::filesystem::path>(options.reference_brdf);
  for (const std::string& file : options.files) {
    formats::ScanTable scan = formats::read_scan(file).table;
    const std::string role = scan.key("role").value_or("");
    if (role == "white") {
      inputs.standards.push_back(calibrate::make_standard(std::move(scan), file, table));
    } else if (role == "dark" || role == "mirror") {
      inputs.others.push_back(
          {scan.key("sample").value_or(file), role, formats::sha256_of_file(file)});
      if (role == "dark")
        inputs.dark.push_back(std::move(scan));
      else
        inputs.notes.push_back(fmt::format(
            "{}: mirror scans are recorded, but polariser axes are not derived from them", file));
    } else {
      throw Error(Place{file},
                  role.empty() ? "the scan has no key `role`"
                               : fmt::format("the scan's role is `{}`", role),
                  "calibration takes scans of role white, dark or mirror: set `role` in the plan");
    }
  }
  if (inputs.standards.empty())
    throw Error("none of the scans is of role `white`",
                "scan a white standard with `role = \"white\"` in the plan and give that file");
  return inputs;
}

std::size_t choose_standard(const std::vector<calibrate::StandardScan>& standards,
                            const std::string& wanted) {
  if (wanted.empty()) return 0;
  std::string known;
  for (std::size_t k = 0; k < standards.size(); ++k) {
    if (standards[k].name == wanted) return k;
    known += (known.empty() ? "" : ", ") + standards[k].name;
  }
  throw Error(fmt::format("no standard is named `{}`", wanted), "choose one of: " + known);
}

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

void print_text(const calibrate::Calibration& calibration) {
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
  if (!calibration.checks.empty())
    fmt::print("\nDHR of the standards\n{:<20} {:>7} {:>8} {:>17} {:>8}\n", "standard", "nm",
               "stated", "computed", "diff.");
  for (const auto& check : calibration.checks)
    fmt::print("{:<20} {:>7g} {:>8} {:>8.4f} +-{:>6.4f} {:>8}{}\n", check.standard,
               check.wavelength_nm,
               std::isnan(check.stated) ? "-" : fmt::format("{:.4f}", check.stated), check.computed,
               check.computed_u,
               std::isnan(check.stated)
                   ? "-"
                   : fmt::format("{:+.2f}%", 100 * (check.computed / check.stated - 1)),
               check.used_for_gain ? "  (fixes the gain)" : "");
  fmt::print("\nAmplifier ranges and dark signal\n{:>7} {:>12} {:>10} {:>13} {:>12}\n", "range",
             "error", "u", "dark x [V]", "u [V]");
  for (const auto& range : calibration.ranges.ranges) {
    const auto level = calibration.dark.at(range.gain);
    fmt::print("{:>7g} {:>12.3g} {:>10.2g} {:>13.3g} {:>12.2g}{}{}\n", range.gain, range.error,
               range.u, level.x_v, level.x_u, range.measured ? "" : "  nominal ratio",
               level.records > 0 ? "" : "  dark not measured");
  }
}

nlohmann::json number(double value) {
  return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json(nullptr);
}

nlohmann::json to_json(const calibrate::Calibration& calibration, const std::string& file) {
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
  for (const auto& check : calibration.checks)
    out["checks"].push_back({{"standard", check.standard},
                             {"wavelength_nm", check.wavelength_nm},
                             {"stated", number(check.stated)},
                             {"computed", check.computed},
                             {"computed_u", check.computed_u},
                             {"used_for_gain", check.used_for_gain}});
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
  for (const auto& input : calibration.inputs)
    out["inputs"].push_back({{"name", input.name}, {"role", input.role}, {"sha256", input.sha256}});
  return out;
}

void run(const Options& options, const Common& common) {
  std::vector<std::string> inputs_named = options.files;
  inputs_named.push_back(options.reference_brdf);
  require_product_output(inputs_named, options.output);
  Inputs inputs = read_inputs(options);
  calibrate::CalibrateOptions settings;
  settings.standard = choose_standard(inputs.standards, options.standard);
  settings.max_degree = options.max_degree;
  settings.range_tolerance = options.range_tolerance;
  settings.bias = options.bias == "on"    ? calibrate::CalibrateOptions::Bias::on
                  : options.bias == "off" ? calibrate::CalibrateOptions::Bias::off
                                          : calibrate::CalibrateOptions::Bias::automatic;
  calibrate::Calibration calibration =
      calibrate::calibrate(inputs.standards, inputs.dark, settings);
  calibration.inputs.insert(calibration.inputs.end(), inputs.others.begin(), inputs.others.end());
  calibration.notes.insert(calibration.notes.end(), inputs.notes.begin(), inputs.notes.end());
  formats::Provenance provenance;
  provenance.program = "umov " UMOV_VERSION;
  provenance.command = common.command_line;
  calibrate::write_calibration(options.output, calibration, provenance);
  if (common.json) {
    fmt::print("{}\n", to_json(calibration, options.output).dump());
    return;
  }
  if (common.quiet) return;
  print_text(calibration);
  for (const std::string& note : calibration.notes) fmt::print("note: {}\n", note);
  fmt::print("\n{} written\n", options.output);
}

}  // namespace

void add_calibrate_command(CLI::App& root, const Common& common) {
  auto options = std::make_shared<Options>();
  auto* command =
      root.add_subcommand("calibrate", "Gain and instrument function from scans of standards");
  command
      ->add_option("scans", options->files,
                   "scans (scan.h5 or .csv) of role white, dark or mirror; the first white one "
                   "fixes the gain")
      ->required();
  command->add_option("-o,--output", options->output, "calibration file to write (cal.h5)")
      ->required();
  command->add_option("--standard", options->standard,
                      "name (key `sample`) of the white standard that fixes the gain");
  command->add_option("--reference-brdf", options->reference_brdf,
                      "table of the standard's own BRDF: brdf.h5, CSV or the NIST PTFE table");
  command
      ->add_option("--detector-bias", options->bias,
                   "polarisation bias of the detector: auto applies it where it is significant")
      ->check(CLI::IsMember({"auto", "on", "off"}))
      ->capture_default_str();
  command
      ->add_option("--max-degree", options->max_degree,
                   "highest degree of the instrument function, 0 = it is one")
      ->check(CLI::Range(0, 16))
      ->capture_default_str();
  command
      ->add_option("--range-tolerance", options->range_tolerance,
                   "relative uncertainty of amplifier ranges that no overlap fixes")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  command->footer(
      "Examples:\n"
      "  umov calibrate white99.h5 white70.h5 white50.h5 -o cal.h5\n"
      "  umov calibrate white.csv --reference-brdf ptfe.h5 -o cal.h5 --json");
  command->callback([options, &common] { run(*options, common); });
}

}  // namespace umov::cli
