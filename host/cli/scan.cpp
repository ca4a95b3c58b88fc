// umov scan: runs a plan on an instrument.
#include <filesystem>
#include <memory>
#include <string>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "host/cli/command.hpp"
#include "host/cli/device_choice.hpp"
#include "host/cli/interrupt.hpp"
#include "host/cli/progress.hpp"
#include "host/errors/error.hpp"
#include "host/scan/plan.hpp"
#include "host/scan/runner.hpp"

namespace umov::cli {
namespace {

struct Options {
  std::string plan;
  std::string output;
  std::string name;
  bool resume = false;
  bool force = false;
  bool dry_run = false;
  DeviceChoice device;
};

void print_dry_run(const scan::Plan& plan, const Options& options, const Common& common) {
  const auto program = scan::expand(plan);
  if (common.json) {
    fmt::print(
        "{}\n",
        nlohmann::json{{"rows", program.rows.size()}, {"blocks", program.blocks.size()}}.dump());
    return;
  }
  fmt::print("{}: {} rows\n", options.plan, program.rows.size());
  for (const auto& block : program.blocks) {
    fmt::print("  block {:<10} rows {} to {}\n", block.name, block.first, block.last);
  }
}

/// What stands after Ctrl-C, with the whole command line: a resumed scan needs the same device,
/// sample and seed.
std::string how_to_go_on(const scan::RunSummary& summary, const Options& options,
                         const Common& common) {
  const bool resumable = std::filesystem::exists(scan::journal_path(options.output));
  std::string command = common.command_line;
  if (resumable && !options.resume) command += " --resume";
  if (summary.records == 0) {
    return fmt::format("stopped before anything was measured. {} with: {}",
                       resumable ? "Go on" : "Start again", command);
  }
  return fmt::format("stopped after {} of {} records; {} is valid. Go on with: {}", summary.records,
                     summary.total, options.output, command);
}

void run(const Options& options, const Common& common) {
  auto plan = scan::load_plan(options.plan);
  const std::string plan_sample = plan.sample;
  if (!options.name.empty()) plan.sample = options.name;
  if (options.dry_run) {
    print_dry_run(plan, options, common);
    return;
  }
  if (options.output.empty()) {
    throw Error("no output file was named", "add -o scan.h5");
  }
  catch_interrupts();
  Progress progress("scan", common.quiet);
  scan::RunOptions run_options;
  run_options.output = options.output;
  run_options.resume = options.resume;
  run_options.overwrite = options.force;
  run_options.program = std::string("umov ") + UMOV_VERSION;
  run_options.command = common.command_line;
  run_options.connect = connector(options.device, plan_sample, common.seed);
  run_options.progress = [&](const scan::RunProgress& now) {
    progress.update(now.done, now.total, now.note);
  };
  run_options.keep_going = [] { return !interrupt_flag().load(); };
  const auto summary = scan::run_scan(plan, run_options);
  progress.finish();

  if (!summary.complete) throw Interrupted(how_to_go_on(summary, options, common));
  if (common.json) {
    fmt::print("{}\n", nlohmann::json{{"file", options.output},
                                      {"records", summary.records},
                                      {"resumed_from", summary.resumed_from},
                                      {"lost_links", summary.lost_links},
                                      {"saturated", summary.saturated},
                                      {"instrument_time_s", summary.instrument_time_s}}
                           .dump());
  } else if (!common.quiet) {
    fmt::print("{}: {} records in {:.0f} s of instrument time", options.output, summary.records,
               summary.instrument_time_s);
    if (summary.resumed_from > 0) fmt::print(", resumed from record {}", summary.resumed_from);
    if (summary.lost_links > 0) fmt::print(", {} lost links taken up again", summary.lost_links);
    if (summary.saturated > 0) fmt::print(", {} saturated", summary.saturated);
    fmt::print("\n");
  }
}

}  // namespace

void add_scan_command(CLI::App& root, const Common& common) {
  auto options = std::make_shared<Options>();
  auto* command =
      root.add_subcommand("scan", "Measure every row of a plan; raw records go to scan.h5");
  command->add_option("plan", options->plan, "plan file (TOML)")->required();
  command->add_option("-o,--output", options->output, "scan.h5 to write");
  command->add_option("--name", options->name,
                      "name of the sample as recorded (default: the plan's)");
  command->add_flag("--resume", options->resume, "finish an interrupted scan");
  command->add_flag("--force", options->force, "replace an existing file");
  command->add_flag("--dry-run", options->dry_run, "only say what the plan would measure");
  add_device_options(*command, options->device);
  command->footer(
      "Examples:\n"
      "  umov scan examples/plans/quick.toml -o quick.h5\n"
      "  umov scan plan.toml --device tcp:localhost:5025 -o scan.h5\n"
      "  umov scan plan.toml -o scan.h5 --resume");
  command->callback([options, &common] { run(*options, common); });
}

}  // namespace umov::cli
