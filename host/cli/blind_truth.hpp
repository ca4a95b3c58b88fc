// What a run over withheld-effect cases may take from their sealed truth: further scans, and for
// comparison the names of the effects. The diagnosing code sees neither file nor folder.
#pragma once

#include <string>
#include <vector>

#include "hil/blind/truth_file.hpp"
#include "host/formats/scan_table.hpp"

namespace umov::cli {

class SealedTruth {
 public:
  /// Throws umov::Error where the truth is not the one the cases were sealed with.
  SealedTruth(const std::string& cases, const std::string& truth_folder);

  /// What `umov blind scan TRUTH CASE --menu a,b` writes.
  formats::ScanTable further_scan(const std::string& name,
                                  const std::vector<std::string>& menus) const;
  /// The catalogue's effects in the case, of a crowd those with ρ ≥ 3 beside the others, with
  /// `sample_model` where the material is not one Gaussian lobe: for the oracle.
  std::vector<std::string> known_causes(const std::string& name) const;
  /// The catalogue's effects in the case: for a diagnosis that must do without them.
  std::vector<std::string> effects(const std::string& name) const;

 private:
  blind::TruthFile file_;
};

}  // namespace umov::cli
