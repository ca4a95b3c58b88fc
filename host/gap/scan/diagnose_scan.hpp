// The diagnosis of a gonioreflectometer scan: the engine on the signal chain.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "host/formats/scan_table.hpp"
#include "host/gap/engine/diagnosis.hpp"
#include "host/gap/scan/picture.hpp"
#include "host/gap/scan/scan_model.hpp"

namespace umov::gap::scan {

struct ScanDiagnoseOptions {
  ScanModelOptions model;
  DiagnoseOptions diagnose;
  /// Effects that the diagnosis must do without, by name.
  std::vector<std::string> without;
  bool picture = false;  ///< also what a page shows: ScanDiagnosis::picture
};

struct ScanDiagnosis {
  Diagnosis answer;
  std::string model;  ///< the base's
  std::size_t records = 0, used = 0;
  std::vector<std::string> notes;
  std::vector<Tolerance> limits;  ///< sizes of effects that are in order (ScanModel::limits)
  /// The first of answer.next_scan as a plan for `umov scan`; empty where there is none.
  std::string next_plan;
  std::shared_ptr<const Picture> picture;  ///< null unless asked for
};

/// Diagnoses scans of one sample together. Throws umov::Error where the records cannot carry a
/// diagnosis, and for names in `without` that no effect has.
ScanDiagnosis diagnose_scans(const std::vector<formats::ScanTable>& scans,
                             const ScanDiagnoseOptions& options = {});

}  // namespace umov::gap::scan
