// umov blind score: answers to withheld-effect cases against their sealed truth.
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "hil/blind/case_set.hpp"
#include "host/cli/answer_folder.hpp"
#include "host/cli/blind.hpp"
#include "host/cli/output_file.hpp"
#include "host/errors/error.hpp"
#include "host/formats/atomic_file.hpp"
#include "host/gap/benchmark/score_page.hpp"

namespace umov::cli {
namespace {

namespace fs = std::filesystem;
namespace benchmark = gap::benchmark;

struct Options {
  std::string folder, truth, answers, output;

  fs::path answer_folder() const { return answers.empty() ? folder : answers; }
};

std::optional<benchmark::Answer> rival(const nlohmann::json& all, const char* name,
                                       const std::string& place) {
  const auto found = all.find(name);
  if (found == all.end() || found->is_null()) return std::nullopt;
  return benchmark::parse_answer(found->dump(), place);
}

std::optional<benchmark::Entry> entry_of(const benchmark::TrueCase& truth, const fs::path& folder) {
  if (!fs::exists(folder / answer_name)) return std::nullopt;
  benchmark::Entry entry;
  entry.truth = truth;
  const auto answer = [&](const char* name) {
    const fs::path path = folder / name;
    return benchmark::parse_answer(formats::read_whole_file(path), path.string());
  };
  const auto json = [&](const char* name) {
    const fs::path path = folder / name;
    nlohmann::json parsed =
        nlohmann::json::parse(formats::read_whole_file(path), nullptr, /*allow_exceptions=*/false);
    if (!parsed.is_object())
      throw Error({path.string()}, "is no JSON object", "remove it, or run the case anew");
    return parsed;
  };
  entry.first = answer(answer_name);
  entry.last = fs::exists(folder / followed_name) ? answer(followed_name) : entry.first;
  if (fs::exists(folder / rivals_name)) {
    const nlohmann::json all = json(rivals_name);
    const std::string place = (folder / rivals_name).string();
    entry.largest_residual = rival(all, "largest_residual", place);
    entry.forward_bic = rival(all, "forward_bic", place);
    entry.oracle = rival(all, "oracle", place);
    entry.rivals_failed = all.value("failed", "");
  }
  if (fs::exists(folder / timing_name)) {
    const nlohmann::json timing = json(timing_name);
    entry.seconds = timing.value("seconds", 0.0);
    entry.further_seconds = timing.value("followed_seconds", 0.0);
  }
  return entry;
}

void run(const Options& options, const Common& common) {
  if (!blind::seal_fits(options.folder, options.truth)) {
    throw Error({options.truth}, "is not the truth that " + options.folder + " was sealed with",
                "name the folder that was made with it; a truth that was changed is void");
  }
  const fs::path folder = options.answer_folder();
  const fs::path truth_path = fs::path(options.truth) / blind::truth_name;
  if (!options.output.empty()) require_product_output({truth_path.string()}, options.output);
  const std::vector<benchmark::TrueCase> truths =
      benchmark::parse_truth(formats::read_whole_file(truth_path), truth_path.string());
  std::vector<benchmark::Entry> entries;
  for (const benchmark::TrueCase& truth : truths)
    if (auto entry = entry_of(truth, folder / truth.name)) entries.push_back(std::move(*entry));
  if (entries.empty()) {
    throw Error({folder.string()}, "has no case_NNNN/answer.json",
                "run `umov blind run`, or write there what your own program answers");
  }
  benchmark::ScoreSource source;
  source.seal_sha256 = blind::read_seal(options.folder).sha256;
  source.cases = truths.size();
  source.seed = common.seed;
  if (fs::exists(folder / run_name)) {
    source.run = formats::read_whole_file(folder / run_name);
    const nlohmann::json record = nlohmann::json::parse(source.run, nullptr, false);
    if (!record.is_object() || !record.contains("program") || !record.contains("options")) {
      throw Error({(folder / run_name).string()}, "is no record of a run",
                  "remove it where the answers are another program's");
    }
    source.leave_out = record.at("options").value("leave_out", false);
  }
  if (!options.output.empty())
    formats::replace_file(options.output, benchmark::score_markdown(entries, source));
  if (common.json) {
    fmt::print("{}", benchmark::score_json(entries, source));
  } else if (!common.quiet) {
    fmt::print("{}", benchmark::score_markdown(entries, source, true));
  }
}

}  // namespace

void add_blind_score(CLI::App& blind, const Common& common) {
  auto options = std::make_shared<Options>();
  auto* command = blind.add_subcommand(
      "score", "Answers against the sealed truth: every measure with its interval and target");
  command->add_option("folder", options->folder, "folder of the cases, with their SEAL")
      ->required();
  command->add_option("--truth", options->truth, "folder of the sealed truth")->required();
  command->add_option("--answers", options->answers,
                      "folder with case_NNNN/answer.json; else beside the scans");
  command->add_option("-o,--output", options->output, "write all tables to this Markdown file");
  command->footer(
      "Answers of any program are scored: answer.json in the JSON of `umov diagnose`, and\n"
      "answer_followed.json where it had the scans it asked for.\n"
      "Example:\n  umov blind score cases --truth sealed -o score.md");
  command->callback([options, &common] { run(*options, common); });
}

}  // namespace umov::cli
