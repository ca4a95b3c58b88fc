// umov diagnose: where a simulation parts from a scan, which effects cause it, how far the gap
// closes, which scan to take next.
#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <vector>

#include "host/cli/command.hpp"
#include "host/cli/diagnosis_text.hpp"
#include "host/cli/output_file.hpp"
#include "host/cli/progress.hpp"
#include "host/errors/error.hpp"
#include "host/formats/atomic_file.hpp"
#include "host/formats/scan_h5.hpp"
#include "host/formats/sha256.hpp"
#include "host/gap/answer/diagnosis_json.hpp"
#include "host/gap/scan/diagnose_scan.hpp"

namespace umov::cli {
namespace {

struct Arguments {
  std::vector<std::string> scans;
  std::string json, next;
  gap::scan::ScanDiagnoseOptions options;
};

std::string hash_of(const std::vector<std::string>& files) {
  if (files.size() == 1) return formats::sha256_of_file(files[0]);
  formats::Sha256 all;
  for (const std::string& file : files) all.update(formats::sha256_of_file(file));
  return all.hex_digest();
}

void run(Arguments& a, const Common& common) {
  if (!a.json.empty()) require_product_output(a.scans, a.json);
  if (!a.next.empty()) require_product_output(a.scans, a.next);
  std::vector<formats::ScanTable> scans;
  for (const std::string& path : a.scans) scans.push_back(formats::read_scan(path).table);

  Progress progress("diagnose", common.quiet || common.json);
  a.options.diagnose.search.seed = common.seed;
  a.options.diagnose.search.threads = common.threads;
  a.options.diagnose.search.progress = [&](double share, const char* stage) {
    progress.update(share, 1.0, stage);
  };
  const gap::scan::ScanDiagnosis result = gap::scan::diagnose_scans(scans, a.options);
  progress.finish();

  gap::AnswerSource source;
  source.records = result.records;
  source.used = result.used;
  source.sha256 = hash_of(a.scans);
  source.version = UMOV_VERSION;
  source.command = common.command_line;
  source.seed = common.seed;
  source.model = result.model;
  source.notes = result.notes;
  const std::string text = gap::diagnosis_to_json(result.answer, source);
  if (!a.json.empty()) formats::replace_file(a.json, text);
  if (!a.next.empty() && !result.next_plan.empty()) formats::replace_file(a.next, result.next_plan);
  if (common.json) {
    fmt::print("{}", text);
  } else if (!common.quiet) {
    print_diagnosis(result.answer, result.notes);
  }
}

}  // namespace

void add_diagnose_command(CLI::App& root, const Common& common) {
  const auto a = std::make_shared<Arguments>();
  CLI::App* command = root.add_subcommand(
      "diagnose", "Where a simulation misses a scan, which effects cause it, how far it closes");
  command->add_option("scans", a->scans, "scan.h5 or Scan CSV; several of one sample together")
      ->required();
  command->add_option("--json", a->json, "write the diagnosis to this file");
  command->add_option("--next", a->next,
                      "write the plan of the scan to take next, where one is prescribed");
  command->add_option("-m,--model", a->options.model.model, "reflectance model of the simulation")
      ->capture_default_str();
  command->add_option("--without", a->options.without, "effects that the diagnosis must do without")
      ->delimiter(',');
  command->callback([a, &common] { run(*a, common); });
}

}  // namespace umov::cli
