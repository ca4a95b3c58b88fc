// umov scan: runs a plan on an instrument.
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "host/cli/command.hpp"
#include "host/cli/device_choice.hpp"
#include "host/cli/interrupt.hpp"
#include "host/cli/operator.hpp"
#include "host/cli/progress.hpp"
#include "host/errors/error.hpp"
#include "host/scan/plan.hpp"
#include "host/scan/runner.hpp"
#include "host/scan/scan_part.hpp"

namespace umov::cli {
namespace {

struct Options {
  std::string plan;
  std::string output;
  std::string name;
  std::string block;
  std::string arrange = "auto";
  bool resume = false;
  bool force = false;
  bool dry_run = false;
  DeviceChoice device;
};

void print_dry_run(const std::vector<scan::ScanPart>& parts, const Options& options,
                   const Common& common) {
  std::size_t rows = 0, blocks = 0;
  std::vector<scan::Program> programs;
  for (const auto& part : parts) {
    programs.push_back(scan::expand(part.plan));
    rows += programs.back().rows.size();
    blocks += programs.back().blocks.size();
  }
  if (common.json) {
    fmt::print("{}\n", nlohmann::json{{"rows", rows}, {"blocks", blocks}}.dump());
    return;
  }
  fmt::print("{}: {} rows\n", options.plan, rows);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (i > 0) fmt::print("white tile, a scan of its own:\n");
    for (const auto& block : programs[i].blocks) {
      const auto change = scan::arrangement_of(block);
      fmt::print("  block {:<10} rows {} to {}{}\n", block.name, block.first, block.last,
                 change.plain() ? "" : "  set-up: " + change.text());
    }
  }
}

/// What stands after Ctrl-C, with the whole command line: a resumed scan needs the same device,
/// sample and seed.
std::string how_to_go_on(const scan::RunSummary& summary, const scan::ScanPart& part,
                         const Options& options, const Common& common) {
  const bool resumable = std::filesystem::exists(scan::journal_path(part.output));
  std::string command = common.command_line;
  if ((resumable || part.output != options.output) && !options.resume) command += " --resume";
  if (summary.records == 0) {
    return fmt::format("stopped before anything was measured{}. {} with: {}",
                       part.output != options.output ? " of " + part.output.string() : "",
                       resumable ? "Go on" : "Start again", command);
  }
  return fmt::format("stopped after {} of {} records; {} is valid. Go on with: {}", summary.records,
                     summary.total, part.output.string(), command);
}

/// Who changes the set-up; empty: nobody, blocks that need it are refused.
scan::Arranger choose_arranger(const Options& options, const Instrument& instrument,
                               Progress& progress) {
  const auto by_hand = ask_operator([&progress] { progress.finish(); });
  const auto by_itself = [&instrument](const scan::ArrangementRequest& request) {
    instrument.arrange(request.wanted.settings);
    return true;
  };
  if (options.arrange == "refuse") return {};
  if (options.arrange == "made") {
    if (instrument.arrange)
      throw Error("--arrange made is for an instrument that someone can touch",
                  "leave it out: the embedded emulator changes its set-up by itself");
    return [](const scan::ArrangementRequest&) { return true; };
  }
  if (instrument.arrange) {
    if (options.arrange != "ask") return by_itself;
    return [=](const scan::ArrangementRequest& request) {
      return by_hand(request) && by_itself(request);
    };
  }
  if (options.arrange == "ask" || operator_at_terminal()) return by_hand;
  return {};
}

/// Before anything is measured: set-ups that nobody will change, or that can't all have been made.
void check_arrangements(const std::vector<scan::ScanPart>& parts, const Options& options,
                        bool attended) {
  for (const auto& part : parts) {
    const auto stretches = scan::stretches(scan::expand(part.plan), part.standing);
    if (!attended) scan::require_plain(stretches, part.plan.name);
    if (options.arrange == "made" && (stretches.size() > 1 || parts.size() > 1))
      throw Error(
          {part.plan.name},
          "--arrange made, but the plan needs more than one set-up: " + stretches.front().blocks +
              " and " + (stretches.size() > 1 ? stretches[1].blocks : "white_tile"),
          "choose the blocks that were set up for with --block");
  }
}

bool is_complete(const scan::ScanPart& part) {
  return std::filesystem::exists(part.output) &&
         !std::filesystem::exists(scan::journal_path(part.output));
}

bool is_begun(const scan::ScanPart& part) {
  return std::filesystem::exists(part.output) ||
         std::filesystem::exists(scan::journal_path(part.output));
}

/// The parts still to be measured of a scan that is resumed: all, where nothing is left to do, so
/// that the runner says so.
std::vector<scan::ScanPart> left_to_do(const std::vector<scan::ScanPart>& parts) {
  std::vector<scan::ScanPart> left;
  for (const auto& part : parts)
    if (!is_complete(part)) left.push_back(part);
  return left.empty() ? parts : left;
}

void print_summary(const scan::ScanPart& part, const scan::RunSummary& summary) {
  fmt::print("{}: {} records in {:.0f} s of instrument time", part.output.string(), summary.records,
             summary.instrument_time_s);
  if (summary.resumed_from > 0) fmt::print(", resumed from record {}", summary.resumed_from);
  if (summary.lost_links > 0) fmt::print(", {} lost links taken up again", summary.lost_links);
  if (summary.saturated > 0) fmt::print(", {} saturated", summary.saturated);
  fmt::print("\n");
}

nlohmann::json summary_json(const scan::ScanPart& part, const scan::RunSummary& summary) {
  return {{"file", part.output.string()},         {"records", summary.records},
          {"resumed_from", summary.resumed_from}, {"lost_links", summary.lost_links},
          {"saturated", summary.saturated},       {"instrument_time_s", summary.instrument_time_s}};
}

void run(const Options& options, const Common& common) {
  auto plan = scan::load_plan(options.plan);
  const std::string plan_sample = plan.sample;
  if (!options.name.empty()) plan.sample = options.name;
  const auto only = options.block.empty() ? std::nullopt : std::optional(options.block);
  auto parts = scan::scan_parts(plan, options.output, only);
  if (options.dry_run) {
    print_dry_run(parts, options, common);
    return;
  }
  if (options.output.empty()) {
    throw Error("no output file was named", "add -o scan.h5");
  }
  catch_interrupts();
  Progress progress("scan", common.quiet);
  const auto instrument = choose_instrument(options.device, plan_sample, common.seed);
  scan::RunOptions run_options;
  run_options.overwrite = options.force;
  run_options.program = std::string("umov ") + UMOV_VERSION;
  run_options.command = common.command_line;
  run_options.connect = instrument.connect;
  run_options.arrange = choose_arranger(options, instrument, progress);
  run_options.progress = [&](const scan::RunProgress& now) {
    progress.update(now.done, now.total, now.note);
  };
  run_options.tell = [&](const std::string& what) {
    if (common.quiet) return;
    progress.finish();
    fmt::print(stderr, "{}\n", what);
  };
  run_options.keep_going = [] { return !interrupt_flag().load(); };
  check_arrangements(parts, options, static_cast<bool>(run_options.arrange));
  if (options.resume) {
    parts = left_to_do(parts);
  } else if (!options.force) {
    for (const auto& part : parts)
      if (part.output != options.output && is_begun(part))
        throw Error({part.output.string()}, "the file of the white tile's scan exists",
                    "choose another name for the scan, go on with --resume, or use --force");
  }

  auto report = nlohmann::json::array();
  for (const auto& part : parts) {
    run_options.output = part.output;
    run_options.standing = part.standing;
    // The tile's scan may not have been begun when the sample's was interrupted.
    run_options.resume = options.resume && (part.output == options.output || is_begun(part));
    const auto summary = scan::run_scan(part.plan, run_options);
    progress.finish();
    if (!summary.complete) throw Interrupted(how_to_go_on(summary, part, options, common));
    report.push_back(summary_json(part, summary));
    if (!common.json && !common.quiet) print_summary(part, summary);
  }
  if (common.json) {
    auto out = report.at(0);
    if (report.size() > 1) out["white"] = report.at(1);
    fmt::print("{}\n", out.dump());
  }
}

}  // namespace

void add_scan_command(CLI::App& root, const Common& common) {
  auto options = std::make_shared<Options>();
  auto* command =
      root.add_subcommand("scan", "Measure every row of a plan; raw records go to scan.h5");
  command->add_option("plan", options->plan, "plan file (TOML)")->required();
  command->add_option("-o,--output", options->output,
                      "scan.h5 to write; a white tile's scan goes to scan-white.h5 beside it");
  command->add_option("--name", options->name,
                      "name of the sample as recorded (default: the plan's)");
  command->add_option("--block", options->block,
                      "only the blocks of that name; main: the plan's own grid");
  command
      ->add_option("--arrange", options->arrange,
                   "who changes the set-up where a block needs it. ask: you, before Enter; made: "
                   "you did already (with --block); refuse: nobody; auto: the embedded emulator "
                   "by itself, else ask at a terminal and refuse without one")
      ->check(CLI::IsMember({"auto", "ask", "made", "refuse"}))
      ->capture_default_str();
  command->add_flag("--resume", options->resume, "finish an interrupted scan");
  command->add_flag("--force", options->force, "replace an existing file");
  command->add_flag("--dry-run", options->dry_run, "only say what the plan would measure");
  add_device_options(*command, options->device);
  command->footer(
      "Examples:\n"
      "  umov scan examples/plans/quick.toml -o quick.h5\n"
      "  umov scan plan.toml --device tcp:localhost:5025 -o scan.h5\n"
      "  umov scan plan.toml -o scan.h5 --resume\n"
      "  umov scan plan.toml --device tcp:bench:5025 --block flip --arrange made -o flip.h5");
  command->callback([options, &common] { run(*options, common); });
}

}  // namespace umov::cli
