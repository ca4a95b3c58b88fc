#include "host/cli/study/ceilings.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "host/cli/study/bench.hpp"
#include "host/cli/study/embedded_plans.hpp"
#include "host/gap/benchmark/ceiling.hpp"
#include "host/gap/scan/next_scan.hpp"
#include "host/gap/scan/scan_model.hpp"

namespace umov::study {
namespace {

using gap::scan::Record;
using gap::scan::ScanModel;

constexpr std::array samples{"red-gloss", "black-semi-gloss", "black-matte"};
constexpr std::array visibilities{5.0, 10.0, 20.0};
constexpr int trials = 400;  // of each effect and visibility
constexpr double relative_noise = 0.003;
/// A plan: the first scan's order, and the further scans taken with it.
struct Plan {
  const char* name;
  bool serpentine;
  std::vector<const char*> further;
};

const std::vector<Plan>& plans() {
  static const std::vector<Plan> all{
      {"one-way", false, {}},
      {"serpentine", true, {}},
      {"+ ±45° block", true, {"pm45"}},
      {"+ flip", true, {"pm45", "flip"}},
      {"+ shutter, out of plane, neutral density", true, {"pm45", "flip", "shutter", "oop", "nd"}}};
  return all;
}

/// The scan as the plan takes it.
ScanModel planned(const ScanModel& model, const Plan& plan, const gap::Explanation& truth) {
  std::vector<Record> records = model.records().records;
  for (Record& r : records) r.direction = plan.serpentine && r.row % 2 != 0 ? -1 : 1;
  const ScanModel first = model.with_records(records);
  for (const char* menu : plan.further) {
    const std::vector<Record> further = gap::scan::further_records(first, menu, truth);
    records.insert(records.end(), further.begin(), further.end());
  }
  // They read what the fit foretells: nothing pulls at its parameters.
  const ScanModel taken = model.with_records(records);
  Eigen::VectorXd mean;
  taken.predict(truth, mean, nullptr);
  const auto used = static_cast<Eigen::Index>(taken.used());
  Eigen::Index next = 0;
  for (Record& r : records) {
    if (r.saturated) continue;
    r.x_v = mean[next];
    r.y_v = mean[used + next];
    ++next;
  }
  return model.with_records(records);
}

}  // namespace

Page ceilings(const Options& options) {
  Bench bench(options, options.folder / "scans", "ideal", samples[0]);
  const auto report = [&](double share, const std::string& what) {
    if (options.keep_going && !options.keep_going()) throw Stopped{};
    if (options.progress) options.progress(share, what);
  };
  std::map<std::pair<std::size_t, double>, gap::NamingRates> rates;  // by plan and visibility
  std::vector<std::size_t> records(plans().size(), 0);
  for (std::size_t m = 0; m < samples.size(); ++m) {
    const auto done = [&](double part) {
      return (static_cast<double>(m) + part) / static_cast<double>(samples.size());
    };
    formats::ScanTable scan =
        bench.measure(fmt::format("ceilings-{}", samples[m]), embedded_plan("effects"), samples[m],
                      done(0), done(0.2));
    for (const auto& [key, value] : data_sheet) scan.set_key(key, value);
    const ScanModel model({scan});
    const gap::Refit start =
        gap::refit(model, gap::base_explanation(model),
                   gap::Whitening(model.noise(model.observations().value), {relative_noise, 0, 0}));
    for (std::size_t p = 0; p < plans().size(); ++p) {
      report(done(0.2 + 0.16 * static_cast<double>(p)),
             fmt::format("{}, {}", samples[m], plans()[p].name));
      const ScanModel whole = planned(model, plans()[p], start.explanation);
      records[p] = whole.used();
      Eigen::VectorXd mean;
      whole.predict(start.explanation, mean, nullptr);
      const gap::Whitening whitening(whole.noise(mean), {relative_noise, 0, 0});
      const gap::Refit at = gap::refit(whole, start.explanation, whitening, 0);
      const gap::NamingCeiling ceiling(whole, at, whitening, options.threads);
      for (const double rho : visibilities)
        rates[{p, rho}] += ceiling.rates(rho, trials, options.seed + 10 * m + p, options.threads);
    }
  }

  Page page("ceilings", "How often could a single effect be named?", "");
  page.paragraph(fmt::format(
      "What a plan allows one who knows all but the effect: effects of the catalogue at a known "
      "visibility ρ (length in "
      "standard deviations of what a refit of the base leaves of them, at whatever "
      "size that takes), every one {} "
      "times on each of {} samples of "
      "the emulated instrument, in noise of {} % of the signal beside the records' "
      "own. They are named by evidence "
      "with everything known but which effect it is: linear signatures, the noise, the "
      "priors of sizes, and that "
      "there is one effect and no more. *Set*: all effects within {} of the best in "
      "twice the logarithm of the "
      "evidence. Further scans of the menu are as the diagnosis prescribes them: every "
      "second angle of two "
      "incidences.",
      trials, samples.size(), 100 * relative_noise, gap::NamingCeiling::ambiguous));
  std::vector<std::vector<std::string>> rows;
  page.numbers()["plans"] = Json::array();
  for (std::size_t p = 0; p < plans().size(); ++p) {
    std::vector<std::string> row{plans()[p].name, fmt::format("{}", records[p])};
    for (const double rho : visibilities) {
      const gap::NamingRates& r = rates[{p, rho}];
      const auto share = [&](double n) { return n / std::max(1, r.drawn); };
      row.push_back(fmt::format("{:.2f}", share(r.named)));
      row.push_back(
          fmt::format("{:.2f} ({:.1f})", share(r.in_set), share(static_cast<double>(r.set_size))));
      page.numbers()["plans"].push_back({{"plan", plans()[p].name},
                                         {"rho", rho},
                                         {"drawn", r.drawn},
                                         {"top1", share(r.named)},
                                         {"in_set", share(r.in_set)},
                                         {"set_size", share(static_cast<double>(r.set_size))}});
    }
    rows.push_back(std::move(row));
  }
  std::vector<std::string> head{"plan", "records"};
  for (const double rho : visibilities) {
    head.push_back(fmt::format("named, ρ = {}", rho));
    head.push_back("in the set (its size)");
  }
  page.table(head, rows);
  for (const std::size_t p : {std::size_t{0}, plans().size() - 1}) {
    const gap::NamingRates& r = rates[{p, 10.0}];
    std::vector<std::pair<int, std::pair<std::string, std::string>>> worst;
    for (const auto& [pair, n] : r.taken_for) worst.emplace_back(-n, pair);
    std::sort(worst.begin(), worst.end());
    if (worst.size() > 12) worst.resize(12);
    std::vector<std::vector<std::string>> confusions;
    for (const auto& [n, pair] : worst)
      confusions.push_back(
          {"`" + pair.first + "`", "`" + pair.second + "`",
           fmt::format("{:.2f}", -n / static_cast<double>(trials * samples.size()))});
    page.paragraph(
        fmt::format("**What is taken for what** most often at ρ = 10, {}:", plans()[p].name));
    page.table({"effect", "taken for", "share of its trials"}, confusions);
  }
  page.paragraph(fmt::format("Made by `{}`.",
                             options.command.empty() ? "umov study ceilings" : options.command));
  return page;
}

}  // namespace umov::study
