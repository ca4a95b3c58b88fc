// The sealed truth of a set of cases, as JSON.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "hil/blind/case.hpp"

namespace umov::blind {

struct TruthFile {
  std::uint64_t seed = 1;
  std::vector<CaseTruth> cases;

  /// Throws umov::Error listing the range of names for an unknown case.
  const CaseTruth& find(const std::string& name) const;
};

/// The text of truth.json.
std::string truth_text(const TruthFile& truth);

/// Reads it back: scans made from it are those of the original, bit by bit. Throws umov::Error for
/// a file that is not one.
TruthFile read_truth(const std::filesystem::path& path);
TruthFile parse_truth(const std::string& text, const std::string& name);

}  // namespace umov::blind
