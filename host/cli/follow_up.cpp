#include "host/cli/follow_up.hpp"

#include <filesystem>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <CLI/CLI.hpp>

#include "host/cli/interrupt.hpp"
#include "host/cli/operator.hpp"
#include "host/cli/progress.hpp"
#include "host/errors/error.hpp"
#include "host/formats/atomic_file.hpp"
#include "host/formats/scan_h5.hpp"
#include "host/scan/plan.hpp"
#include "host/scan/runner.hpp"
#include "host/scan/scan_part.hpp"

namespace umov::cli {
namespace {

namespace fs = std::filesystem;

/// "umov native EMU-5cee92b3 at emulator" without the way to it.
std::string instrument_of(const formats::ScanTable& scan) {
  const std::string device = scan.key("device").value_or("");
  return device.substr(0, device.rfind(" at "));
}

gap::Outcome outcome_of(const gap::Diagnosis& d) {
  gap::Outcome outcome{d.verdict, {}, d.ambiguity_sets};
  for (const gap::Cause& c : d.causes) outcome.causes.emplace_back(c.effect, c.probability);
  return outcome;
}

/// One prescribed scan with its files.
struct Prescription {
  fs::path plan, output;
  scan::Plan read;
};

Prescription write_plan(const FollowUpOptions& options, const std::string& first_scan,
                        const std::string& text, std::size_t round) {
  const fs::path first = first_scan;
  const fs::path folder = options.keep.empty() ? first.parent_path() : fs::path(options.keep);
  if (!options.keep.empty()) fs::create_directories(folder);
  const std::string name = fmt::format("{}.next-{}", first.stem().string(), round);
  Prescription p{folder / (name + ".toml"), folder / (name + ".h5"), {}};
  const bool begun = fs::exists(p.output) || fs::exists(scan::journal_path(p.output));
  const bool ours = fs::exists(p.plan) && scan::program_id(scan::load_plan(p.plan)) ==
                                              scan::program_id(scan::parse_plan(text, name));
  if (begun && !ours)
    throw Error(Place{p.output.string()}, "does not belong to the scan that is prescribed now",
                "name a folder for these scans with --keep, or remove it");
  if (!begun) formats::replace_file(p.plan, text);
  p.read = scan::load_plan(p.plan);
  return p;
}

/// What a person has to do for the plan; empty where the controller does it all.
std::vector<std::string> by_hand(const scan::Plan& plan) {
  std::vector<std::string> sentences;
  const auto all = scan::stretches(scan::expand(plan), {});
  for (const scan::Stretch& s : all) {
    if (s.arrangement.plain()) continue;
    for (std::string& sentence : scan::instructions({s.arrangement, scan::Arrangement{}, s.blocks}))
      sentences.push_back(std::move(sentence));
  }
  return sentences;
}

/// Measures, or goes on with, or takes what is there.
void measure(const Prescription& p, const Common& common, const Instrument& instrument,
             Progress& progress) {
  const bool unfinished = fs::exists(scan::journal_path(p.output));
  if (fs::exists(p.output) && !unfinished) return;
  scan::RunOptions run;
  run.output = p.output;
  run.resume = unfinished;
  run.program = std::string("umov ") + UMOV_VERSION;
  run.command = common.command_line;
  run.connect = instrument.connect;
  if (instrument.arrange) {
    run.arrange = [&](const scan::ArrangementRequest& request) {
      instrument.arrange(request.wanted.settings);
      return true;
    };
  } else if (operator_at_terminal()) {
    run.arrange = ask_operator([&progress] { progress.finish(); });
  }
  run.progress = [&](const scan::RunProgress& now) {
    progress.update(now.done, now.total, now.note);
  };
  run.keep_going = [] { return !interrupt_flag().load(); };
  const scan::RunSummary summary = scan::run_scan(p.read, run);
  progress.finish();
  if (!summary.complete)
    throw Interrupted(fmt::format("stopped after {} of {} records of {}. Go on with: {}",
                                  summary.records, summary.total, p.output.string(),
                                  common.command_line));
}

}  // namespace

void add_follow_up_options(CLI::App& command, FollowUpOptions& options) {
  auto* device = command.add_option("--follow-up", options.device,
                                    "emulator or tcp:HOST:PORT: takes the scans that are "
                                    "prescribed there and diagnoses all together");
  command.add_option("--follow-ups", options.rounds, "at most so many")
      ->check(CLI::Range(1, 9))
      ->needs(device)
      ->capture_default_str();
  command
      .add_option("--keep", options.keep,
                  "folder of the further scans (default: beside the first scan)")
      ->needs(device);
  add_plant_options(command, options.instrument);
  // They describe the instrument that takes further scans: without these they would say nothing.
  for (const char* name : {"--sample", "--preset", "--plant", "--plant-set"})
    command.get_option(name)->needs(device);
}

FollowUps take_follow_ups(const FollowUpOptions& options, const Common& common,
                          std::vector<std::string>& files, std::vector<formats::ScanTable>& scans,
                          gap::scan::ScanDiagnosis& result,
                          const std::function<gap::scan::ScanDiagnosis()>& diagnose) {
  FollowUps done;
  const std::string first = files.front();
  const std::string sample = scans.front().key("sample").value_or("");
  const std::string known_instrument = instrument_of(scans.front());
  for (int round = 1; round <= options.rounds; ++round) {
    const gap::Outcome before = outcome_of(result.answer);
    if (before.ambiguity_sets.empty()) break;
    if (result.next_plan.empty()) {
      done.ended = "nothing on the menu of further scans tells these apart";
      break;
    }
    const std::string menu = result.answer.next_scan.front().menu;
    const Prescription p =
        write_plan(options, first, result.next_plan, static_cast<std::size_t>(round));
    catch_interrupts();
    Progress progress(fmt::format("scan {}", menu), common.quiet || common.json);
    DeviceChoice choice = options.instrument;
    choice.device = options.device;
    // Chance is not the same again: the first scan was session 0.
    choice.session = static_cast<std::uint64_t>(round);
    const Instrument instrument = choose_instrument(choice, sample, common.seed);
    const std::vector<std::string> hands = by_hand(p.read);
    if (!hands.empty() && !instrument.arrange && !operator_at_terminal() && !fs::exists(p.output)) {
      done.ended = fmt::format(
          "the scan \"{}\" needs a hand at the instrument: {} Then run at a terminal: umov scan {} "
          "--device {} -o {}, and diagnose both files together",
          menu, fmt::join(hands, " "), p.plan.string(), options.device, p.output.string());
      break;
    }
    measure(p, common, instrument, progress);
    formats::ScanTable further = formats::read_scan(p.output.string()).table;
    if (!known_instrument.empty() && instrument_of(further) != known_instrument)
      throw Error(Place{p.output.string()},
                  fmt::format("was measured on {}, the first scan on {}", instrument_of(further),
                              known_instrument),
                  "name the first scan's instrument: for an emulated one the same --sample, "
                  "--preset, --plant, --plant-set and --seed");
    files.push_back(p.output.string());
    scans.push_back(std::move(further));
    result = diagnose();
    done.rounds.push_back({menu, p.output.string(), before, outcome_of(result.answer)});
  }
  return done;
}

}  // namespace umov::cli
