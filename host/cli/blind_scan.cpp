// umov blind scan: one more scan of a case's sample on its instrument, from the sealed truth.
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "hil/blind/case_set.hpp"
#include "host/cli/blind.hpp"
#include "host/cli/blind_plan.hpp"
#include "host/cli/output_file.hpp"
#include "host/errors/error.hpp"
#include "host/formats/scan_csv.hpp"
#include "host/scan/scan_part.hpp"

namespace umov::cli {
namespace {

struct Options {
  std::string truth, name, plan, output;
  std::vector<std::string> menus;
};

void write(const blind::CaseTruth& truth, const std::vector<blind::RowBlock>& blocks,
           const std::filesystem::path& output, const Options& options, const Common& common) {
  std::vector<std::string> inputs = {
      (std::filesystem::path(options.truth) / blind::truth_name).string()};
  if (!options.plan.empty()) inputs.push_back(options.plan);
  require_product_output(inputs, output.string());
  const formats::ScanTable table = blind::further_scan(truth, blocks);
  formats::write_scan_csv(table, output);
  if (common.json) {
    fmt::print(
        "{}\n",
        nlohmann::json{{"scan", output.string()}, {"case", truth.name}, {"records", table.size()}}
            .dump());
  } else if (!common.quiet) {
    fmt::print("{}: {} records\n", output.string(), table.size());
  }
}

void run(const Options& options, const Common& common) {
  if (options.menus.empty() == options.plan.empty())
    throw Error("what shall be scanned?", "give --menu NAME or --plan FILE, one of the two");
  const blind::TruthFile file =
      blind::read_truth(std::filesystem::path(options.truth) / blind::truth_name);
  const blind::CaseTruth& truth = file.find(options.name);
  if (options.plan.empty()) {
    std::vector<blind::RowBlock> blocks;
    for (const std::string& menu : options.menus)
      blocks.push_back(blind::menu_block(truth.plan, menu));
    return write(truth, blocks, options.output, options, common);
  }
  const scan::Plan plan = scan::load_plan(options.plan);
  for (const scan::ScanPart& part : scan::scan_parts(plan, options.output, std::nullopt))
    write(truth, bench_blocks(part.plan), part.output, options, common);
}

}  // namespace

void add_blind_scan(CLI::App& blind, const Common& common) {
  auto options = std::make_shared<Options>();
  auto* command = blind.add_subcommand(
      "scan", "One more scan of a case: same sample, same instrument, time running on");
  command->add_option("truth", options->truth, "folder with the sealed truth")->required();
  command->add_option("case", options->name, "such as case_0001")->required();
  command
      ->add_option("--menu", options->menus,
                   "further scan: reverse, serpentine, flip, pm45, shutter, nd, iris, oop, "
                   "white_tile, repeat, long_pass or no_sample; several with commas")
      ->delimiter(',');
  command->add_option("--plan", options->plan, "or a scan plan (TOML)");
  command->add_option("-o,--output", options->output, "Scan CSV")->required();
  command->footer("Example:\n  umov blind scan sealed case_0001 --menu flip -o flip.csv");
  command->callback([options, &common] { run(*options, common); });
}

}  // namespace umov::cli
