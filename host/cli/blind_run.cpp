// umov blind run: diagnoses every case of a set, on any number of cores and machines, resumably.
#include <atomic>
#include <chrono>
#include <exception>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "hil/blind/case_set.hpp"
#include "host/cli/answer_folder.hpp"
#include "host/cli/blind.hpp"
#include "host/cli/blind_truth.hpp"
#include "host/cli/case_claims.hpp"
#include "host/cli/interrupt.hpp"
#include "host/cli/own_process.hpp"
#include "host/cli/progress.hpp"
#include "host/cli/quick_diagnosis.hpp"
#include "host/errors/error.hpp"
#include "host/formats/atomic_file.hpp"
#include "host/gap/benchmark/case_answer.hpp"
#include "host/gap/benchmark/rivals.hpp"
#include "host/gap/scan/effect_list.hpp"
#include "host/parallel/ranks/ranks.hpp"

namespace umov::cli {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using Json = nlohmann::ordered_json;

struct Options {
  std::string folder, truth, answers, commit;
  std::string model = gap::scan::ScanModelOptions{}.model;
  std::vector<std::string> without;
  int follow_ups = 2;
  bool quick = false, without_floors = false, leave_out = false;

  fs::path answer_folder() const { return answers.empty() ? folder : answers; }
};

/// Names in the diagnosis' catalogue.
const std::set<std::string>& known_effects() {
  static const std::set<std::string> names = [] {
    gap::scan::Scale scale;
    scale.wavelengths_nm = {532, 633, 814};
    std::set<std::string> all;
    for (const gap::Effect& effect : gap::scan::catalogue(scale)) all.insert(effect.name);
    return all;
  }();
  return names;
}

/// All that an answer depends on besides the scan.
std::string option_text(const Options& o, const Common& common) {
  Json json = {{"seed", common.seed},
               {"model", o.model},
               {"quick", o.quick},
               {"without", o.without},
               {"leave_out", o.leave_out},
               {"follow_ups", o.truth.empty() ? 0 : o.follow_ups},
               {"floors", !o.without_floors},
               {"oracle", !o.truth.empty() && !o.without_floors}};
  if (fs::exists(fs::path(o.folder) / blind::seal_name))
    json["cases_sha256"] = blind::read_seal(o.folder).sha256;
  return json.dump();
}

class BlindRun {
 public:
  BlindRun(const Options& options, const Common& common, const Ranks& ranks)
      : options_(options),
        common_(common),
        ranks_(ranks),
        folder_(options.answer_folder()),
        names_(cases_in(options.folder)) {
    if (!options.truth.empty()) truth_.emplace(options.folder, options.truth);
    require_same_run(folder_,
                     run_record(UMOV_VERSION, options.commit, option_text(options, common)));
    claims_.emplace(folder_);
  }

  /// Comes back when every case is answered, by whomever. Throws Interrupted.
  void run() {
    std::vector<std::thread> workers;
    for (int w = 0; w < threads(); ++w) workers.emplace_back([this] { work(); });
    show_progress();
    for (std::thread& worker : workers) worker.join();
    if (failure_) std::rethrow_exception(failure_);
    if (done() < names_.size()) {
      throw Interrupted(fmt::format(
          "stopped with {} of {} cases answered; the same command goes on", done(), names_.size()));
    }
  }

  std::size_t cases() const { return names_.size(); }
  std::size_t answered_here() const { return here_; }

 private:
  /// A rank of mpirun is one core's; alone, the process takes all of them. A case is one thread's.
  int threads() const {
    if (common_.threads > 0) return common_.threads;
    if (ranks_.size() > 1) return 1;
    return static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  }

  std::size_t done() const {
    std::size_t count = 0;
    for (const std::string& name : names_)
      if (answered(folder_, name)) ++count;
    return count;
  }

  bool stopped() const { return interrupt_flag().load() || failed_.load(); }

  void show_progress() {
    const bool silent = common_.quiet || common_.json || ranks_.rank() != 0;
    Progress progress("cases", silent);
    const std::size_t at_start = done();
    auto counted = std::chrono::steady_clock::now();
    while (working_.load() > 0 || !begun_.load()) {
      std::this_thread::sleep_for(100ms);
      if (silent || std::chrono::steady_clock::now() - counted < 2s) continue;
      counted = std::chrono::steady_clock::now();
      // Time left is reckoned from what was done since the start.
      progress.update(static_cast<double>(done() - at_start),
                      static_cast<double>(names_.size() - at_start),
                      at_start > 0 ? fmt::format("and {} before", at_start) : "");
    }
    progress.finish();
  }

  void work() {
    ++working_;
    begun_ = true;
    try {
      // Each rank begins elsewhere, so that they seldom ask for the same case.
      const std::size_t offset = names_.size() * ranks_.rank() / ranks_.size();
      std::vector<bool> known(names_.size(), false);
      for (std::size_t open = names_.size(); open > 0 && !stopped();) {
        bool worked = false;
        open = 0;
        for (std::size_t k = 0; k < names_.size() && !stopped(); ++k) {
          const std::size_t i = (offset + k) % names_.size();
          if (known[i]) continue;
          if (answered(folder_, names_[i])) {
            known[i] = true;
            continue;
          }
          ++open;
          const auto claim = claims_->claim(i + 1);
          if (!claim || answered(folder_, names_[i])) continue;
          answer_safely(names_[i]);
          ++here_;
          worked = true;
        }
        // What is left is in other hands; should one of them die, its cases come free.
        if (open > 0 && !worked) std::this_thread::sleep_for(500ms);
      }
    } catch (...) {
      const std::scoped_lock lock(mutex_);
      if (!failure_) failure_ = std::current_exception();
      failed_ = true;
    }
    --working_;
  }

  /// A case that brings the diagnosis down is answered as failed: one in thousands must not stop
  /// the others.
  void answer_safely(const std::string& name) const {
    const fs::path own = folder_ / name;
    fs::create_directories(own);
    const std::optional<std::string> end = in_own_process([&] { answer(name); });
    if (!end || stopped() || answered(folder_, name)) return;
    for (const char* part : {followed_name, rivals_name, timing_name}) fs::remove(own / part);
    formats::replace_file(own / answer_name,
                          gap::benchmark::failed_answer("the diagnosis ended by: " + *end));
  }

  void answer(const std::string& name) const {
    const fs::path own = folder_ / name;
    gap::benchmark::CaseOptions how;
    how.version = UMOV_VERSION;
    how.follow_ups = options_.follow_ups;
    how.diagnose.model.model = options_.model;
    how.diagnose.without = options_.without;
    how.diagnose.diagnose.search.seed = common_.seed;
    how.diagnose.diagnose.search.threads = 1;
    how.quick = options_.quick;
    if (options_.quick) make_quick(how.diagnose);
    if (options_.leave_out) {
      for (const std::string& effect : truth_->effects(name))
        if (known_effects().contains(effect)) how.diagnose.without.push_back(effect);
    }
    gap::benchmark::TakeScan take;
    if (truth_ && options_.follow_ups > 0) {
      take = [&](const std::vector<std::string>& menus) {
        return truth_->further_scan(name, menus);
      };
    }
    const gap::benchmark::CaseAnswer answer =
        gap::benchmark::answer_case(fs::path(options_.folder) / name / "scan.csv", how, take);

    Json timing = {{"seconds", answer.seconds}};
    if (!answer.further_text.empty()) {
      timing["followed_seconds"] = answer.further_seconds;
      formats::replace_file(own / followed_name, answer.further_text);
    }
    if (!options_.without_floors && !answer.failed) {
      const double start = gap::benchmark::thread_seconds();
      std::optional<std::vector<std::string>> known;
      if (truth_) known = truth_->known_causes(name);
      std::string rivals;
      try {
        rivals = gap::benchmark::rival_answers(answer.scans, how.diagnose, answer.first, known);
      } catch (const std::exception& error) {
        // The case counts without what it would be compared with; the score says so.
        rivals = Json{{"failed", error.what()}}.dump(1) + "\n";
      }
      formats::replace_file(own / rivals_name, rivals);
      timing["rivals_seconds"] = gap::benchmark::thread_seconds() - start;
    }
    formats::replace_file(own / timing_name, timing.dump() + "\n");
    formats::replace_file(own / answer_name, answer.text);
  }

  const Options& options_;
  const Common& common_;
  const Ranks& ranks_;
  fs::path folder_;
  std::vector<std::string> names_;
  std::optional<SealedTruth> truth_;
  std::optional<CaseClaims> claims_;
  std::atomic<std::size_t> here_{0};
  std::atomic<int> working_{0};
  std::atomic<bool> begun_{false}, failed_{false};
  std::mutex mutex_;
  std::exception_ptr failure_;
};

void run(const Options& options, const Common& common) {
  if (options.leave_out && options.truth.empty())
    throw Error("--leave-out needs to know what to leave out",
                "name the sealed truth with --truth");
  for (const std::string& name : options.without) {
    if (!known_effects().contains(name)) {
      throw Error("no effect is called \"" + name + "\"",
                  fmt::format("choose from: {}", fmt::join(known_effects(), ", ")));
    }
  }
  const Ranks ranks;
  catch_interrupts();
  BlindRun work(options, common, ranks);
  work.run();
  if (ranks.rank() != 0) return;
  if (common.json) {
    fmt::print("{}\n", Json{{"answers", options.answer_folder().string()},
                            {"cases", work.cases()},
                            {"answered_here", work.answered_here()},
                            {"ranks", ranks.size()}}
                           .dump());
  } else if (!common.quiet) {
    fmt::print("{}: all {} cases answered, {} of them {}\n", options.answer_folder().string(),
               work.cases(), work.answered_here(), ranks.size() > 1 ? "by the first rank" : "now");
  }
}

}  // namespace

void add_blind_run(CLI::App& blind, const Common& common) {
  auto options = std::make_shared<Options>();
  auto* command = blind.add_subcommand(
      "run",
      "Diagnose every case of a set; several processes, or `mpirun umov blind run`, share it");
  command->add_option("folder", options->folder, "folder of the cases")->required();
  command->add_option("--truth", options->truth,
                      "folder of the sealed truth: prescribed scans are taken from it, and an "
                      "oracle is told the effects");
  command->add_option("--answers", options->answers,
                      "folder for the answers; else beside the scans");
  command
      ->add_option("--followups", options->follow_ups,
                   "rounds of prescribed scans, where --truth is given")
      ->check(CLI::Range(0, 5))
      ->capture_default_str();
  command->add_flag("--quick", options->quick, "a shorter search");
  command->add_flag("--without-floors", options->without_floors,
                    "no answers of largest residual, forward BIC and oracle");
  command->add_option("--without", options->without, "effects that the diagnosis must do without")
      ->delimiter(',');
  command->add_flag("--leave-out", options->leave_out,
                    "diagnose each case without the very effects that are in it");
  command->add_option("-m,--model", options->model, "reflectance model of the simulation")
      ->capture_default_str();
  command->add_option("--commit", options->commit,
                      "what the record of the run says of the program's commit");
  command->footer(
      "A run that was stopped goes on with the same command. Answers of another build or with\n"
      "other options are not mixed in.\n"
      "Example:\n  mpirun -n 8 umov blind run cases --truth sealed");
  command->callback([options, &common] { run(*options, common); });
}

}  // namespace umov::cli
