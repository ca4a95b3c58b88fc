// umov diagnose: where a simulation parts from a scan, which effects cause it, how far the gap
// closes, which scan to take next.
#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <vector>

#include "host/cli/command.hpp"
#include "host/cli/diagnose_luminaire.hpp"
#include "host/cli/diagnose_surface.hpp"
#include "host/cli/diagnosis_text.hpp"
#include "host/cli/effects_text.hpp"
#include "host/cli/follow_up.hpp"
#include "host/cli/known_beforehand.hpp"
#include "host/cli/output_file.hpp"
#include "host/cli/progress.hpp"
#include "host/cli/quick_diagnosis.hpp"
#include "host/errors/error.hpp"
#include "host/formats/atomic_file.hpp"
#include "host/formats/scan_h5.hpp"
#include "host/formats/sha256.hpp"
#include "host/gap/answer/diagnosis_json.hpp"
#include "host/gap/scan/diagnose_scan.hpp"
#include "host/report/diagnosis_page.hpp"

namespace umov::cli {
namespace {

struct Arguments {
  std::vector<std::string> scans;
  KnownFiles known;
  FollowUpOptions follow_up;
  bool quick = false;
  std::string json, next, report, surface, luminaire;
  bool effects = false;
  gap::scan::ScanDiagnoseOptions options;
};

std::string hash_of(const std::vector<std::string>& files) {
  if (files.size() == 1) return formats::sha256_of_file(files[0]);
  formats::Sha256 all;
  for (const std::string& file : files) all.update(formats::sha256_of_file(file));
  return all.hex_digest();
}

/// The sample as the scan's heading names it; empty where it does not.
std::string sample_of(const formats::ScanTable& scan) {
  return scan.key("sample").value_or("");
}

/// What only a gonioreflectometer's scan has was asked for of something else.
bool asks_of_a_scan(const Arguments& a) {
  return !a.next.empty() || !a.known.calibration.empty() || !a.known.tolerances.empty() ||
         !a.known.fit.empty() || a.known.hold || !a.follow_up.device.empty() ||
         a.options.model.model != gap::scan::ScanModelOptions{}.model;
}

/// No output may be an input, raw records, or another output.
void require_outputs(const Arguments& a) {
  std::vector<std::string> taken = a.scans;
  for (const auto& [kind, path] : list_of(a.known)) taken.push_back(path);
  for (const std::string& output : {a.json, a.next, a.report}) {
    if (output.empty()) continue;
    require_product_output(taken, output);
    taken.push_back(output);
  }
}

void run_luminaire(const Arguments& a, const Common& common) {
  if (a.scans.size() > 1 || asks_of_a_scan(a))
    throw Error("--luminaire goes with one map, --json, --report, --without and --quick only",
                "umov diagnose map.exr --luminaire scene.toml --report diagnosis.html");
  diagnose_luminaire({a.scans[0], a.luminaire, a.json, a.report, a.options.without, a.quick},
                     common);
}

void run(Arguments& a, const Common& common) {
  if (a.effects && !a.surface.empty())
    throw Error("effects of surfaces depend on what is simulated of the scene; there is no list",
                "docs/diagnosis.md has them all; umov diagnose brdf.h5 --surface scene.toml tries "
                "those that the scene allows");
  if (a.effects)
    return print_effects(a.luminaire.empty() ? scan_effects() : luminaire_effects(a.luminaire),
                         common.json);
  if (a.scans.empty())
    throw Error("no scan was named",
                "umov diagnose scan.h5; `umov diagnose --effects` lists effects");
  if (!a.surface.empty()) {
    if (a.scans.size() > 1 || asks_of_a_scan(a) || !a.report.empty() || a.quick ||
        !a.options.without.empty())
      throw Error("--surface goes with one brdf.h5 and --json only",
                  "umov diagnose brdf.h5 --surface scene.toml --json diagnosis.json");
    return diagnose_surface(a.scans[0], a.surface, a.json, common);
  }
  if (!a.luminaire.empty()) return run_luminaire(a, common);
  require_outputs(a);
  a.options.picture = !a.report.empty();
  std::vector<formats::ScanTable> scans;
  for (const std::string& path : a.scans) scans.push_back(formats::read_scan(path).table);
  a.options.model.knowledge = read_known(a.known);
  if (a.quick) make_quick(a.options);

  Progress progress("diagnose", common.quiet || common.json);
  a.options.diagnose.search.seed = common.seed;
  a.options.diagnose.search.threads = common.threads;
  a.options.diagnose.search.progress = [&](double share, const char* stage) {
    progress.update(share, 1.0, stage);
  };
  const auto diagnose = [&] {
    gap::scan::ScanDiagnosis made = gap::scan::diagnose_scans(scans, a.options);
    progress.finish();
    return made;
  };
  gap::scan::ScanDiagnosis result = diagnose();
  FollowUps follow_ups;
  if (!a.follow_up.device.empty())
    follow_ups = take_follow_ups(a.follow_up, common, a.scans, scans, result, diagnose);

  gap::AnswerSource source;
  source.records = result.records;
  source.used = result.used;
  source.sha256 = hash_of(a.scans);
  source.version = UMOV_VERSION;
  source.command = common.command_line;
  source.seed = common.seed;
  source.model = result.model;
  source.notes = result.notes;
  const gap::Diagnosis& answer = result.answer;
  if (!answer.ambiguity_sets.empty() && answer.next_scan.empty() && follow_ups.ended.empty())
    source.notes.emplace_back(
        "nothing on the menu of further scans tells apart what is in one set");
  source.quick = a.quick;
  source.limits = limits_of(result.limits);
  source.known = list_of(a.known);
  source.follow_ups = follow_ups.rounds;
  source.follow_up_ended = follow_ups.ended;
  const std::string text = gap::diagnosis_to_json(result.answer, source);
  if (!a.json.empty()) formats::replace_file(a.json, text);
  if (!a.next.empty() && !result.next_plan.empty()) formats::replace_file(a.next, result.next_plan);
  if (!a.report.empty())
    formats::replace_file(
        a.report, report::diagnosis_page({&result, source, sample_of(scans.front()), a.scans, ""}));
  if (common.json) {
    fmt::print("{}", text);
  } else if (!common.quiet) {
    print_diagnosis(result.answer, source);
  }
}

}  // namespace

void add_diagnose_command(CLI::App& root, const Common& common) {
  const auto a = std::make_shared<Arguments>();
  CLI::App* command = root.add_subcommand(
      "diagnose", "Where a simulation misses a scan, which effects cause it, how far it closes");
  command->add_option("scans", a->scans,
                      "scan.h5 or Scan CSV; several of one sample together; or what --surface and "
                      "--luminaire ask for");
  command->add_option("--json", a->json, "write the diagnosis to this file");
  command->add_option("--next", a->next,
                      "write the plan of the scan to take next, where one is prescribed");
  command->add_option("--report", a->report, "write the diagnosis as one HTML page with figures");
  auto* surface =
      command->add_option("--surface", a->surface,
                          "scene file of a dirty, wet or rough surface: what a linear mixture of "
                          "its materials misses of a measured brdf.h5");
  command
      ->add_option("--luminaire", a->luminaire,
                   "scene file of a luminaire with its camera: what its simulation misses of a "
                   "measured luminance map (sim.h5, OpenEXR in cd/m2, or CSV)")
      ->excludes(surface);
  command->add_flag(
      "--effects", a->effects,
      "list the effects that a diagnosis knows: of a scan, or with --luminaire of its "
      "maps");
  command->add_option("-m,--model", a->options.model.model, "reflectance model of the simulation")
      ->capture_default_str();
  command->add_option("--without", a->options.without, "effects that the diagnosis must do without")
      ->delimiter(',');
  command->add_option("--calibration", a->known.calibration,
                      "cal.h5: what it knows of the instrument is in the simulation");
  command->add_option("--tolerances", a->known.tolerances,
                      "TOML of how well the bench was aligned, such as "
                      "examples/tolerances/bench.toml");
  auto* fit = command->add_option("--fit", a->known.fit,
                                  "fit.json of umov invert: its model and values to start from");
  fit->excludes("--model");
  command->add_flag("--hold", a->known.hold, "keep the fit's values: the gap of that very fit");
  command->add_flag("--quick", a->quick, "a rougher answer within seconds");
  add_follow_up_options(*command, a->follow_up);
  command->footer(
      "Examples:\n"
      "  umov diagnose scan.h5 --calibration cal.h5 --report diagnosis.html\n"
      "  umov diagnose scan.h5 --calibration cal.h5 --fit fit.json --hold\n"
      "  umov diagnose scan.h5 --calibration cal.h5 --follow-up emulator --seed 7\n"
      "  umov diagnose map.exr --luminaire lamp.toml --report diagnosis.html");
  command->callback([a, &common] { run(*a, common); });
}

}  // namespace umov::cli
