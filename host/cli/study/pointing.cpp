#include "host/cli/study/pointing.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "host/errors/error.hpp"
#include "host/formats/pointing_run.hpp"
#include "host/gap/engine/diagnosis.hpp"
#include "host/gap/pointing/pointing_model.hpp"
#include "host/gap/scan/picture.hpp"

namespace umov::study {
namespace {

namespace fs = std::filesystem;

constexpr std::array runs{std::pair{"21 August 2021", "point_20210821.dat"},
                          std::pair{"2 July 2023", "point_20230702.dat"}};

fs::path data_folder() {
  constexpr auto remedy = "name the folder that holds mmt_pointing in the variable UMOV_DATA";
  const char* named = std::getenv("UMOV_DATA");
  if (named == nullptr) throw Error("the pointing runs are not shipped", remedy);
  fs::path folder = fs::path(named) / "mmt_pointing";
  if (!fs::exists(folder)) throw Error(Place{folder.string()}, "no pointing runs are here", remedy);
  return folder;
}

/// On the sky, both coordinates together, arc seconds.
double rms(const gap::PointingModel& model, const gap::Refit& fit) {
  const Eigen::VectorXd left = model.observations().value - fit.mean;
  return std::sqrt(2 * left.squaredNorm() / static_cast<double>(left.size()));
}

struct Trial {
  std::string withheld;
  gap::Diagnosis answer;
  double before = 0, after = 0;  ///< RMS
  double needed = 0;             ///< Δχ² of the withheld term, by the noise the engine found
};

Trial withhold(const formats::PointingRun& run, const std::vector<std::string>& base,
               const std::string& withheld, const Options& options) {
  const gap::PointingModel model(run, base);
  gap::DiagnoseOptions how;
  how.search.seed = options.seed;
  how.search.threads = options.threads;
  Trial trial{withheld, gap::diagnose(model, how)};
  const gap::Refit& before = trial.answer.search.hypotheses[trial.answer.search.base].refit;
  trial.before = rms(model, before);
  trial.after = rms(model, trial.answer.best);
  double least = before.chi2;
  for (const gap::Hypothesis& h : trial.answer.search.hypotheses)
    least = std::min(least, h.refit.chi2);
  trial.needed = before.chi2 - least;
  return trial;
}

std::string named(const gap::Diagnosis& d) {
  std::vector<std::string> words;
  for (const gap::Cause& c : d.causes)
    words.push_back(fmt::format("`{}` ({:.3f})", c.effect, c.probability));
  for (const auto& set : d.ambiguity_sets)
    words.push_back(fmt::format("not to be told apart: {}", fmt::join(set, ", ")));
  return words.empty() ? "nothing" : fmt::format("{}", fmt::join(words, ", "));
}

std::string sizes(const gap::Diagnosis& d) {
  std::vector<std::string> words;
  for (const gap::Cause& c : d.causes)
    for (const gap::NamedValue& v : c.parameters)
      words.push_back(
          fmt::format("{:.1f} [{:.1f}, {:.1f}]", v.interval.value, v.interval.lo, v.interval.hi));
  return fmt::format("{}", fmt::join(words, "; "));
}

}  // namespace

Page pointing(const Options& options) {
  const fs::path folder = data_folder();
  const std::vector<std::string> terms = gap::PointingModel::names();
  Page page("pointing", "Withheld terms of a telescope's pointing");
  page.paragraph(fmt::format(
      "Command `{}`. Two pointing runs of the 6.5 m MMT (T. E. Pickering, BSD licence; not part of "
      "this repository): where the encoders stood and where the stars were. The pointing model has "
      "{} classical terms besides the zeros of both encoders. Withheld terms are effects that "
      "the simulation lacks; the same engine that diagnoses gonioreflectometer scans is asked "
      "which. Nobody knows this instrument's truth; what is known is how far the RMS falls and "
      "what a fit of all terms needs.",
      options.command, terms.size()));
  Json& numbers = page.numbers();
  double done = 0;
  const double jobs = static_cast<double>(runs.size() * (terms.size() + 1));
  const auto step = [&](const std::string& what) {
    if (options.keep_going && !options.keep_going()) throw Stopped{};
    if (options.progress) options.progress(done++ / jobs, what);
  };
  for (const auto& [day, file] : runs) {
    const formats::PointingRun run = formats::read_pointing_run(folder / file);
    page.heading(fmt::format("{}: {} stars", day, run.size()));
    step("all terms");
    const Trial all = withhold(run, {}, "all", options);
    page.paragraph(fmt::format(
        "**All terms withheld.** Named: {}. RMS {:.2f} before, {:.2f} after, arc seconds on the "
        "sky. Sizes with 95 % intervals, arc seconds: {}.",
        named(all.answer), all.before, all.after, sizes(all.answer)));
    Json own = {{"stars", run.size()}, {"rms_before", all.before}, {"rms_after", all.after}};
    for (const gap::Cause& c : all.answer.causes) own["named"].push_back(c.effect);
    std::vector<std::vector<std::string>> rows;
    for (const std::string& term : terms) {
      step(term);
      std::vector<std::string> others = terms;
      std::erase(others, term);
      const Trial trial = withhold(run, others, term, options);
      rows.push_back({fmt::format("`{}`", term), named(trial.answer),
                      fmt::format("{:.2f}", trial.before), fmt::format("{:.2f}", trial.after),
                      fmt::format("{:.1f}", trial.needed), sizes(trial.answer)});
      own["withheld"].push_back({{"term", term},
                                 {"named", !trial.answer.causes.empty()},
                                 {"rms_before", trial.before},
                                 {"rms_after", trial.after},
                                 {"delta_chi2", trial.needed}});
    }
    page.paragraph("**Each term withheld in turn**, all others in the base model:");
    page.table({"withheld", "named (probability)", "RMS before", "RMS after", "Δχ² of the term",
                "size, arc seconds"},
               rows);
    numbers[file] = std::move(own);
  }
  page.paragraph(
      "Δχ² is what the best explanation that was tried takes from χ², in the noise that the engine "
      "learns from what all terms together leave. A term is named where evidence and withheld "
      "stars "
      "both ask for it. One that is not named is small, or others take its place: then the RMS "
      "without it is nearly that of the full model.");
  return page;
}

}  // namespace umov::study
