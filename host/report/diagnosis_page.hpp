// The page of a diagnosis: where the simulation misses a scan, what causes it, what to measure
// next.
#pragma once

#include <string>
#include <vector>

#include "host/gap/answer/diagnosis_json.hpp"
#include "host/gap/scan/diagnose_scan.hpp"

namespace umov::report {

struct DiagnosisInput {
  const gap::scan::ScanDiagnosis* diagnosis = nullptr;  ///< with its picture
  gap::AnswerSource source;
  std::string sample;              ///< as the scan names it; may be empty
  std::vector<std::string> files;  ///< the scans, as the user named them
  std::string created;             ///< UTC, ISO 8601; empty: now
};

/// The page's data as JSON text that can stand inside a script element; the layout is that which
/// page/diagnosis.js reads. Sizes are bounded whatever the number of records: maps are gridded,
/// traces averaged. Throws umov::Error where the diagnosis has no picture.
std::string diagnosis_data(const DiagnosisInput& input);

/// The whole page, UTF-8. Loads nothing from anywhere.
std::string diagnosis_page(const DiagnosisInput& input);

}  // namespace umov::report
