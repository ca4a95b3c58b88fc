// The diagnosis of one withheld-effect case, from its scan alone.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "host/formats/scan_table.hpp"
#include "host/gap/scan/diagnose_scan.hpp"

namespace umov::gap::benchmark {

struct CaseOptions {
  scan::ScanDiagnoseOptions diagnose;
  int follow_ups = 2;   ///< rounds of prescribed scans
  std::string version;  ///< of the program; stands in the answer
  bool quick = false;   ///< said in the answer; `diagnose` is already so
};

/// One more scan of the case's sample on its instrument: blocks of the menu, one after the other.
using TakeScan = std::function<formats::ScanTable(const std::vector<std::string>& menus)>;

struct CaseAnswer {
  std::vector<formats::ScanTable> scans;  ///< the case's own
  scan::ScanDiagnosis first;              ///< of its own scan
  bool failed = false;                    ///< `first` is empty: the scan cannot be diagnosed
  std::string text;                       ///< answer.json
  /// The answer after the scans that were prescribed; empty where none was taken. It names them
  /// under `followed`, unless it failed.
  std::string further_text;
  double seconds = 0, further_seconds = 0;  ///< of one core
};

/// Reads the scan and diagnoses it on this thread alone; where the answer prescribes a scan and
/// `take` is there, takes it and diagnoses again with both, up to `follow_ups` times: the second
/// time both prescribed menus are scanned one after the other. A scan that cannot be diagnosed is
/// answered with the verdict `failed`.
CaseAnswer answer_case(const std::filesystem::path& scan_csv, const CaseOptions& options,
                       const TakeScan& take);

/// The text of an answer with the verdict `failed`.
std::string failed_answer(const std::string& why);

/// Seconds that this thread has computed.
double thread_seconds();

}  // namespace umov::gap::benchmark
