// umov report: one self-contained page from scans, calibrations, measurements and fits.
#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "host/cli/command.hpp"
#include "host/cli/output_file.hpp"
#include "host/report/report.hpp"

namespace umov::cli {

namespace {

struct Arguments {
  std::vector<std::filesystem::path> files;
  std::filesystem::path output = "report.html";
  std::string title;
};

void run(const Arguments& arguments, const Common& common) {
  report::Options options;
  options.title = arguments.title;
  options.program = std::string("umov ") + UMOV_VERSION;
  options.command = common.command_line;
  std::vector<std::string> inputs;
  for (const auto& file : arguments.files) inputs.push_back(file.string());
  require_product_output(inputs, arguments.output.string());
  const report::Summary summary = report::write_report(arguments.files, arguments.output, options);
  if (common.json) {
    fmt::print("{}\n", nlohmann::json{{"file", arguments.output.string()},
                                      {"samples", summary.samples},
                                      {"bytes", summary.bytes},
                                      {"warnings", summary.warnings}}
                           .dump());
    return;
  }
  if (common.quiet) return;
  fmt::print("{}: {} sample{}, {:.1f} MB\n", arguments.output.string(), summary.samples,
             summary.samples == 1 ? "" : "s", static_cast<double>(summary.bytes) / 1e6);
  for (const std::string& warning : summary.warnings) fmt::print(stderr, "note: {}\n", warning);
}

}  // namespace

void add_report_command(CLI::App& root, const Common& common) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = root.add_subcommand("report", "Write one HTML page with interactive figures");
  command
      ->add_option("files", arguments->files,
                   "scan.h5 or Scan CSV, cal.h5, brdf.h5, fit.json; any number, any order")
      ->required();
  command->add_option("-o,--output", arguments->output, "page to write")->capture_default_str();
  command->add_option("--title", arguments->title,
                      "title of the page (default: the samples' names)");
  command->callback([arguments, &common] { run(*arguments, common); });
}

}  // namespace umov::cli
