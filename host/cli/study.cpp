// umov study: repeats a paper's tables and figures on the emulated instrument.
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "host/cli/command.hpp"
#include "host/cli/interrupt.hpp"
#include "host/cli/output_file.hpp"
#include "host/cli/progress.hpp"
#include "host/cli/study/study.hpp"
#include "host/errors/error.hpp"

namespace umov::cli {
namespace {

struct Options {
  std::string name;
  std::string output;
  std::vector<std::string> models;
};

void list_studies(const Common& common) {
  if (common.json) {
    auto out = nlohmann::json::array();
    for (const auto& study : study::studies())
      out.push_back({{"study", study.name}, {"about", study.about}});
    fmt::print("{}\n", out.dump());
    return;
  }
  for (const auto& study : study::studies()) fmt::print("{:<16} {}\n", study.name, study.about);
}

/// The pages of a study may be replaced by newer ones; anything else in their place may not.
void require_study_folder(const std::filesystem::path& folder, const std::string& name) {
  namespace fs = std::filesystem;
  if (fs::exists(folder) && !fs::is_directory(folder))
    throw Error({folder.string()}, "is no folder", "name a folder with -o");
  const bool empty = !fs::exists(folder) || fs::is_empty(folder);
  const bool ours = fs::exists(folder / "numbers.json") || fs::exists(folder / "scans");
  if (!empty && !ours)
    throw Error({folder.string()}, "holds files that no study wrote",
                "name an empty folder, or one of an earlier run of " + name);
  fs::create_directories(folder);
}

void run(const Options& options, const Common& common) {
  if (options.name.empty()) return list_studies(common);
  const auto& chosen = study::find_study(options.name);
  if (!options.models.empty() && !chosen.takes_models)
    throw Error("the study " + options.name + " takes no models", "leave out --models");
  if (options.output.empty()) throw Error("no output folder was named", "add -o FOLDER");
  require_study_folder(options.output, options.name);
  catch_interrupts();
  Progress progress("study", common.quiet);
  study::Options how;
  how.folder = options.output;
  how.seed = common.seed;
  how.threads = common.threads;
  how.models = options.models;
  how.command = common.command_line;
  how.progress = [&](double share, const std::string& what) {
    progress.update(1000 * share, 1000, what);
  };
  how.keep_going = [] { return !interrupt_flag().load(); };
  try {
    const study::Page page = chosen.run(how);
    page.write(how.folder);
    progress.finish();
    if (common.json) {
      fmt::print("{}\n", page.numbers().dump());
    } else {
      fmt::print("{}: {}.md, index.html, figures.json, numbers.json\n", options.output,
                 page.name());
      for (const auto& target : page.numbers().value("targets", study::Json::array()))
        fmt::print("  {:<4} {}: {} (required {})\n", target["met"].get<bool>() ? "met" : "NOT",
                   target["what"].get<std::string>(), target["found"].get<std::string>(),
                   target["required"].get<std::string>());
    }
  } catch (const study::Stopped&) {
    progress.finish();
    throw Interrupted("stopped; a study begins anew: " + common.command_line);
  }
}

}  // namespace

void add_study_command(CLI::App& root, const Common& common) {
  auto options = std::make_shared<Options>();
  auto* command = root.add_subcommand(
      "study",
      "Repeat a paper, foretell real data, try a diagnosis, as a page; without NAME: list");
  command->add_option("name", options->name, "study");
  command->add_option("-o,--output", options->output,
                      "folder for the page, its figures and the scans behind them");
  command->add_option("--models", options->models, "real-data: only these models, such as ggx+nef")
      ->delimiter(',');
  command->footer("Example:\n  umov study reflectometer -o reflectometer --seed 1");
  command->callback([options, &common] { run(*options, common); });
}

}  // namespace umov::cli
