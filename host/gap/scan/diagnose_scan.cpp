#include "host/gap/scan/diagnose_scan.hpp"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "host/errors/error.hpp"
#include "host/gap/scan/next_scan.hpp"

namespace umov::gap::scan {
namespace {

/// Effects by these names, all members of a family included.
std::vector<std::size_t> numbers_of(const std::vector<std::string>& names,
                                    const std::vector<Effect>& effects) {
  std::vector<std::size_t> numbers;
  for (const std::string& name : names) {
    const std::size_t before = numbers.size();
    for (std::size_t e = 0; e < effects.size(); ++e)
      if (effects[e].name == name) numbers.push_back(e);
    if (numbers.size() == before) {
      std::vector<std::string> known;
      for (const Effect& e : effects)
        if (std::find(known.begin(), known.end(), e.name) == known.end()) known.push_back(e.name);
      throw Error("no effect is called \"" + name + "\"",
                  fmt::format("choose from: {}", fmt::join(known, ", ")));
    }
  }
  return numbers;
}

/// "P/S Y" as words of the answer.
void confine(Where& where) {
  for (Cell& cell : where.cells) {
    const auto slash = cell.channel.find('/');
    if (slash == std::string::npos) continue;
    const auto blank = cell.channel.find(' ');
    cell.also.emplace_back("polarizer", cell.channel.substr(0, slash));
    cell.also.emplace_back("analyzer", cell.channel.substr(slash + 1, blank - slash - 1));
    cell.also.emplace_back("component", blank == std::string::npos ? "x" : "y");
  }
}

}  // namespace

ScanDiagnosis diagnose_scans(const std::vector<formats::ScanTable>& scans,
                             const ScanDiagnoseOptions& options) {
  const ScanModel model(scans, options.model);
  DiagnoseOptions engine = options.diagnose;
  engine.search.without = numbers_of(options.without, model.effects());
  ScanDiagnosis result{
      diagnose(model, engine), options.model.model, 0, model.used(), model.records().notes, {}};
  result.answer.next_scan = further_scans(model, result.answer);
  if (!result.answer.next_scan.empty())
    result.next_plan = plan_of(result.answer.next_scan.front(), model,
                               scans.front().key("sample").value_or("sample"));
  for (const formats::ScanTable& scan : scans) result.records += scan.size();
  confine(result.answer.where);
  confine(result.answer.unexplained);
  return result;
}

}  // namespace umov::gap::scan
