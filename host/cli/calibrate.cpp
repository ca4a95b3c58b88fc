// umov calibrate: gain, instrument function, dark and phase from scans of standards.
#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "host/calibrate/calibration.hpp"
#include "host/calibrate/calibration_file.hpp"
#include "host/calibrate/campaign.hpp"
#include "host/calibrate/standard_file.hpp"
#include "host/cli/calibration_text.hpp"
#include "host/cli/command.hpp"
#include "host/cli/output_file.hpp"
#include "host/cli/polarization_text.hpp"
#include "host/errors/error.hpp"
#include "host/formats/scan_h5.hpp"
#include "host/formats/sha256.hpp"

namespace umov::cli {
namespace {

struct Options {
  std::vector<std::string> files;
  std::string campaign;
  std::string output;
  std::string standard;
  std::string reference_brdf;
  std::string bias = "auto";
  int max_degree = 8;
  double range_tolerance = 1e-3;
  std::string mirror_index = calibrate::PolarizationOptions{}.index;
};

struct Inputs {
  std::vector<calibrate::StandardScan> standards;
  std::vector<formats::ScanTable> dark;
  std::vector<std::pair<std::string, formats::ScanTable>> mirrors;  ///< with the file's name
  std::vector<calibrate::CalibrationInput> others;                  ///< dark and mirror scans
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
        inputs.mirrors.emplace_back(file, std::move(scan));
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

/// The campaign's calibration; files named on the command line take the place of its list.
calibrate::Calibration evaluate(const Options& options, std::vector<std::string>& inputs,
                                CalibrationView& view) {
  calibrate::CampaignOptions campaign = calibrate::read_campaign(options.campaign);
  if (!options.files.empty()) campaign.scans.assign(options.files.begin(), options.files.end());
  if (!options.standard.empty()) campaign.standard = options.standard;
  const auto scans = calibrate::read_campaign_scans(campaign);
  inputs.push_back(options.campaign);
  for (const auto& scan : scans) inputs.push_back(scan.file);
  require_product_output(inputs, options.output);
  calibrate::Campaign result = calibrate::evaluate_campaign(scans, campaign);
  view.campaign = true;
  view.missing = result.missing;
  view.compare = campaign.compare;
  view.reciprocity_target = campaign.reciprocity_target;
  view.slow_noise = result.linearity.slow_noise;
  return std::move(result.calibration);
}

calibrate::Calibration calibrate_plainly(const Options& options) {
  if (options.files.empty())
    throw Error("no scan is named", "name scans of white standards, or give --campaign FILE");
  Inputs inputs = read_inputs(options);
  calibrate::CalibrateOptions settings;
  settings.standard = choose_standard(inputs.standards, options.standard);
  settings.max_degree = options.max_degree;
  settings.range_tolerance = options.range_tolerance;
  settings.bias = options.bias == "on"    ? calibrate::CalibrateOptions::Bias::on
                  : options.bias == "off" ? calibrate::CalibrateOptions::Bias::off
                                          : calibrate::CalibrateOptions::Bias::automatic;
  if (inputs.mirrors.size() > 1)
    throw Error(Place{inputs.mirrors[1].first}, "is a second mirror scan", "give one of them");
  for (const auto& [file, scan] : inputs.mirrors) {
    calibrate::PolarizationOptions polarization;
    polarization.index = options.mirror_index;
    polarization.range_tolerance = options.range_tolerance;
    settings.polarization = calibrate::find_polarization(scan, polarization);
    for (const std::string& note : settings.polarization->notes)
      inputs.notes.push_back(file + ": " + note);
  }
  calibrate::Calibration calibration =
      calibrate::calibrate(inputs.standards, inputs.dark, settings);
  calibration.inputs.insert(calibration.inputs.end(), inputs.others.begin(), inputs.others.end());
  calibration.notes.insert(calibration.notes.end(), inputs.notes.begin(), inputs.notes.end());
  return calibration;
}

void run(const Options& options, const Common& common) {
  std::vector<std::string> inputs_named = options.files;
  inputs_named.push_back(options.reference_brdf);
  require_product_output(inputs_named, options.output);
  CalibrationView view;
  const calibrate::Calibration calibration =
      options.campaign.empty() ? calibrate_plainly(options) : evaluate(options, inputs_named, view);
  formats::Provenance provenance;
  provenance.program = "umov " UMOV_VERSION;
  provenance.command = common.command_line;
  calibrate::write_calibration(options.output, calibration, provenance);
  if (common.json) {
    fmt::print("{}\n", calibration_json(calibration, view, options.output));
    return;
  }
  if (common.quiet) return;
  print_calibration(calibration, view);
  for (const std::string& note : calibration.notes) fmt::print("note: {}\n", note);
  fmt::print("\n{} written\n", options.output);
}

}  // namespace

void add_calibrate_command(CLI::App& root, const Common& common) {
  auto options = std::make_shared<Options>();
  auto* command =
      root.add_subcommand("calibrate", "Gain and instrument function from scans of standards");
  command->add_option("scans", options->files,
                      "scans (scan.h5 or .csv) of role white, dark or mirror; the first white one "
                      "fixes the gain. With --campaign: any role, instead of the file's own list");
  CLI::Option* campaign =
      command->add_option("--campaign", options->campaign,
                          "campaign.toml: scans and what is known beforehand; evaluates linearity, "
                          "stray light, polariser axes and reciprocity too");
  command->add_option("-o,--output", options->output, "calibration file to write (cal.h5)")
      ->required();
  command->add_option("--standard", options->standard,
                      "name (key `sample`) of the white standard that fixes the gain");
  // A campaign says these in its file.
  command
      ->add_option("--reference-brdf", options->reference_brdf,
                   "table of the standard's own BRDF: brdf.h5, CSV or the NIST PTFE table")
      ->excludes(campaign);
  command
      ->add_option("--detector-bias", options->bias,
                   "polarisation bias of the detector: auto applies it where it is significant")
      ->check(CLI::IsMember({"auto", "on", "off"}))
      ->excludes(campaign)
      ->capture_default_str();
  command
      ->add_option("--max-degree", options->max_degree,
                   "highest degree of the instrument function, 0 = it is one")
      ->check(CLI::Range(0, 16))
      ->excludes(campaign)
      ->capture_default_str();
  command
      ->add_option("--range-tolerance", options->range_tolerance,
                   "relative uncertainty of amplifier ranges that no overlap fixes")
      ->check(CLI::Range(0.0, 1.0))
      ->excludes(campaign)
      ->capture_default_str();
  command
      ->add_option("--mirror-index", options->mirror_index,
                   "refractive index of the mirror: a table of the library or a .yml file")
      ->excludes(campaign)
      ->capture_default_str();
  command->footer(
      "Examples:\n"
      "  umov calibrate white99.h5 white70.h5 white50.h5 -o cal.h5\n"
      "  umov calibrate white.csv --reference-brdf ptfe.h5 -o cal.h5 --json\n"
      "  umov calibrate --campaign campaign.toml -o cal.h5");
  command->callback([options, &common] { run(*options, common); });
}

}  // namespace umov::cli
