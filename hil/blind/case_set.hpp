// A set of withheld-effect cases on disk: scans in one folder, their sealed truth in another.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "hil/blind/case.hpp"
#include "hil/blind/truth_file.hpp"

namespace umov::blind {

inline constexpr const char* truth_name = "truth.json";
inline constexpr const char* seal_name = "SEAL";

struct MakeOptions {
  std::size_t cases = 100;
  std::uint64_t seed = 1;
  int threads = 0;  ///< 0 = all cores; the files do not depend on it
  CaseOptions draws;
  std::function<void(std::size_t done)>
      progress;                      ///< called from one thread at a time; may be empty
  std::function<bool()> keep_going;  ///< may be empty
};

/// Writes `folder`/case_0001/scan.csv …, README.md and SEAL, and `truth_folder`/truth.json. The
/// seal is written last; a set without one is incomplete. Returns false where `keep_going` said no.
/// Throws umov::Error where `folder` is not empty, where there is a truth already, or where the
/// truth would lie within `folder`.
bool make_case_set(const std::filesystem::path& folder, const std::filesystem::path& truth_folder,
                   const MakeOptions& options);

/// What a set's seal says.
struct Seal {
  std::string sha256;
  std::size_t cases = 0;
};
/// Throws umov::Error where there is none.
Seal read_seal(const std::filesystem::path& folder);
/// Does the truth fit the seal? Throws umov::Error where either cannot be read.
bool seal_fits(const std::filesystem::path& folder, const std::filesystem::path& truth_folder);

}  // namespace umov::blind
