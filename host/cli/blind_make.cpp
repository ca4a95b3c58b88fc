// umov blind make: writes a set of cases and, elsewhere, their sealed truth.
#include <filesystem>
#include <memory>
#include <string>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "hil/blind/case_set.hpp"
#include "host/cli/blind.hpp"
#include "host/cli/interrupt.hpp"
#include "host/cli/progress.hpp"
#include "host/errors/error.hpp"

namespace umov::cli {
namespace {

struct Options {
  std::string folder, truth;
  std::size_t cases = 100;
  std::string only_class, only_effect, style;
  double rho_from = 3.0, rho_to = 50.0;
};

blind::Style style_named(const std::string& name) {
  std::string names;
  for (std::size_t i = 0; i < blind::style_names.size(); ++i) {
    if (blind::style_names[i] == name) return static_cast<blind::Style>(i);
    names += (names.empty() ? "" : ", ") + std::string(blind::style_names[i]);
  }
  throw Error("no style of plan is called \"" + name + "\"", "there are " + names);
}

void run(const Options& options, const Common& common) {
  if (!(options.rho_from > 0.0 && options.rho_to >= options.rho_from))
    throw Error("--rho-min and --rho-max are no range", "give 0 < rho-min <= rho-max");
  blind::MakeOptions how;
  how.cases = options.cases;
  how.seed = common.seed;
  how.threads = common.threads;
  how.draws.rho_from = options.rho_from;
  how.draws.rho_to = options.rho_to;
  if (!options.only_class.empty()) how.draws.only_class = blind::class_named(options.only_class);
  if (!options.only_effect.empty())
    how.draws.only_effect = blind::effect_kind(options.only_effect).name;
  if (!options.style.empty()) how.draws.only_style = style_named(options.style);
  catch_interrupts();
  Progress progress("cases", common.quiet);
  how.progress = [&](std::size_t done) {
    progress.update(static_cast<double>(done), static_cast<double>(options.cases));
  };
  how.keep_going = [] { return !interrupt_flag().load(); };
  if (!blind::make_case_set(options.folder, options.truth, how)) {
    progress.finish();
    throw Interrupted("stopped; " + options.folder +
                      " has no seal and is incomplete: remove it and begin anew");
  }
  progress.finish();
  const blind::Seal seal = blind::read_seal(options.folder);
  if (common.json) {
    fmt::print("{}\n", nlohmann::json{{"folder", options.folder},
                                      {"truth", options.truth},
                                      {"cases", seal.cases},
                                      {"seed", common.seed},
                                      {"sha256", seal.sha256}}
                           .dump());
  } else if (!common.quiet) {
    fmt::print("{}: {} cases; their truth in {}, sealed with sha256 {}\n", options.folder,
               seal.cases, options.truth, seal.sha256);
  }
}

}  // namespace

void add_blind_make(CLI::App& blind, const Common& common) {
  auto options = std::make_shared<Options>();
  auto* command =
      blind.add_subcommand("make",
                           "Scans with and without effects; of a hundred cases 20 have none, 30 "
                           "one, 18 two, 7 three, 12 "
                           "one that no catalogue knows, 5 a confounded one, 8 a crowd");
  command->add_option("folder", options->folder, "new folder for the scans")->required();
  command->add_option("--truth", options->truth, "folder for the sealed truth, outside the first")
      ->required();
  command->add_option("--cases", options->cases, "how many")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  command->add_option(
      "--class", options->only_class,
      "all cases of one class: none, single, double, triple, foreign, confounded or "
      "crowded");
  command->add_option("--effect", options->only_effect,
                      "all cases with this effect alone; umov blind effects lists them");
  command->add_option("--style", options->style,
                      "plan of all cases: one-way, serpentine, pm45 or full; else drawn");
  command
      ->add_option("--rho-min", options->rho_from,
                   "smallest size of an effect: whitened signal that a refit of the base leaves")
      ->capture_default_str();
  command->add_option("--rho-max", options->rho_to, "largest size")->capture_default_str();
  command->footer("Example:\n  umov blind make --cases 100 --seed 7 cases --truth sealed");
  command->callback([options, &common] { run(*options, common); });
}

}  // namespace umov::cli
