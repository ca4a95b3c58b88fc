#include "host/cli/study/real_data.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <mutex>

#include <fmt/format.h>

#include "host/brdf/model.hpp"
#include "host/cli/study/in_plane_trial.hpp"
#include "host/cli/study/real_data_page.hpp"
#include "host/errors/error.hpp"
#include "host/formats/atomic_file.hpp"
#include "host/formats/cornell_brdf.hpp"
#include "host/formats/nist_ptfe.hpp"
#include "host/parallel/for_each_index.hpp"

namespace umov::study {
namespace {

namespace fs = std::filesystem;

struct Found {
  std::vector<Trial> trials;
  std::vector<std::string> skipped;
};

fs::path data_folder() {
  const char* named = std::getenv("UMOV_DATA");
  return named == nullptr ? "tests/data" : named;
}

/// The first of the files that exists; empty where none does.
fs::path first_of(const std::vector<fs::path>& names) {
  for (const fs::path& name : names)
    if (fs::exists(data_folder() / name)) return data_folder() / name;
  return {};
}

Found find_trials() {
  Found found;
  const fs::path ptfe = first_of({"nist_ptfe/PTFE.data.csv", "nist_ptfe/ptfe_532_633.csv"});
  if (ptfe.empty()) {
    found.skipped.push_back("sintered PTFE (nist_ptfe/PTFE.data.csv or ptfe_532_633.csv)");
  } else {
    found.trials.push_back(polarimeter_trial("sintered PTFE", formats::read_nist_ptfe(ptfe)));
  }
  for (const auto& [name, file] : {std::pair{"garnet red", "cornell_paint/garnet_red.brdf"},
                                   std::pair{"krylon blue", "cornell_paint/krylon_blue.brdf"}}) {
    const fs::path path = first_of({file});
    if (path.empty()) {
      found.skipped.push_back(fmt::format("{} ({})", name, file));
      continue;
    }
    found.trials.push_back(unpolarised_trial(
        name, formats::read_cornell_brdf(formats::read_whole_file(path), path.string())));
  }
  for (const std::string& what : found.skipped)
    fmt::print(stderr, "skipped, its data are not here: {}; name their folder in UMOV_DATA\n",
               what);
  if (found.trials.empty())
    throw Error("no measured data were found", "name their folder in the variable UMOV_DATA");
  return found;
}

}  // namespace

Page real_data(const Options& options) {
  const Found found = find_trials();
  const auto models = options.models.empty() ? trial_models() : options.models;
  for (const std::string& model : models) brdf::Model::by_name(model);
  std::vector<TrialResult> results(found.trials.size());
  for (std::size_t t = 0; t < results.size(); ++t) {
    results[t].trial = &found.trials[t];
    results[t].attempts.resize(models.size());
  }
  std::mutex reporting;
  std::size_t done = 0;
  const std::size_t jobs = results.size() * models.size();
  for_each_index(jobs, options.threads, [&](std::size_t job) {
    const std::size_t m = job / results.size(), t = job % results.size();
    results[t].attempts[m] = try_model(found.trials[t], models[m], options);
    const std::lock_guard lock(reporting);
    ++done;
    if (options.progress)
      options.progress(static_cast<double>(done) / static_cast<double>(jobs), models[m]);
  });
  for (TrialResult& result : results) {
    for (Attempt& attempt : interpolations(*result.trial))
      result.attempts.push_back(std::move(attempt));
    judge(result);
  }
  return real_data_page(results, found.skipped, options);
}

}  // namespace umov::study
