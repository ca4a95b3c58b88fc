#include "host/gap/benchmark/case_answer.hpp"

#include <ctime>
#include <exception>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "host/formats/scan_csv.hpp"
#include "host/formats/sha256.hpp"
#include "host/gap/answer/diagnosis_json.hpp"

namespace umov::gap::benchmark {
namespace {

std::string text_of(const scan::ScanDiagnosis& diagnosis, const std::string& sha256,
                    const std::string& scans, const CaseOptions& options) {
  AnswerSource source;
  source.records = diagnosis.records;
  source.used = diagnosis.used;
  source.sha256 = sha256;
  source.version = options.version;
  source.seed = options.diagnose.diagnose.search.seed;
  source.quick = options.quick;
  source.command = fmt::format("umov diagnose {} --seed {}{}", scans, source.seed,
                               options.quick ? " --quick" : "");
  source.model = diagnosis.model;
  source.notes = diagnosis.notes;
  return diagnosis_to_json(diagnosis.answer, source);
}

}  // namespace

std::string failed_answer(const std::string& why) {
  return nlohmann::ordered_json{{"verdict", "failed"},
                                {"causes", nlohmann::json::array()},
                                {"ambiguity_sets", nlohmann::json::array()},
                                {"error", why}}
             .dump(1) +
         "\n";
}

double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

CaseAnswer answer_case(const std::filesystem::path& scan_csv, const CaseOptions& options,
                       const TakeScan& take) {
  CaseAnswer result;
  scan::ScanDiagnoseOptions how = options.diagnose;
  how.diagnose.search.threads = 1;
  const double start = thread_seconds();
  const std::string sha256 = formats::sha256_of_file(scan_csv.string());
  try {
    result.scans.push_back(formats::read_scan_csv(scan_csv.string()));
    result.first = scan::diagnose_scans(result.scans, how);
  } catch (const std::exception& error) {
    result.failed = true;
    result.text = failed_answer(error.what());
    result.seconds = thread_seconds() - start;
    return result;
  }
  result.text = text_of(result.first, sha256, scan_csv.filename().string(), options);
  result.seconds = thread_seconds() - start;

  std::vector<std::string> followed;
  std::vector<FurtherScan> prescribed = result.first.answer.next_scan;
  while (take && static_cast<int>(followed.size()) < options.follow_ups && !prescribed.empty()) {
    followed.push_back(prescribed.front().menu);
    try {
      std::vector<formats::ScanTable> scans = result.scans;
      scans.push_back(take(followed));
      const scan::ScanDiagnosis again = scan::diagnose_scans(scans, how);
      const std::string names =
          fmt::format("{} {}.csv", scan_csv.filename().string(), fmt::join(followed, "-"));
      auto json = nlohmann::ordered_json::parse(text_of(again, sha256, names, options));
      json["followed"] = followed;
      result.further_text = json.dump(1) + "\n";
      prescribed = again.answer.next_scan;
    } catch (const std::exception& error) {
      // What is prescribed must be diagnosable: a failure counts against the diagnosis.
      result.further_text = failed_answer(error.what());
      break;
    }
  }
  result.further_seconds = thread_seconds() - start - result.seconds;
  return result;
}

}  // namespace umov::gap::benchmark
