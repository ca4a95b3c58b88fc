// Who works on which case: processes on one or several machines share a folder.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>

namespace umov::cli {

/// A lock on one case, held while it lives.
class CaseClaim {
 public:
  explicit CaseClaim(int file) : file_(file) {}
  CaseClaim(CaseClaim&& other) noexcept : file_(other.file_) { other.file_ = -1; }
  CaseClaim& operator=(CaseClaim&&) = delete;
  ~CaseClaim();

 private:
  int file_;
};

/// Claims are record locks on a file in the shared folder, a byte a case. The kernel, or the file
/// server, releases them with the process that holds them, however it ends: no claim outlives its
/// owner, and none has to be declared stale.
class CaseClaims {
 public:
  /// Throws umov::Error where the folder cannot be written or has no locks.
  explicit CaseClaims(const std::filesystem::path& folder);

  /// Empty where somebody else, in this process or another, is at it.
  std::optional<CaseClaim> claim(std::size_t number) const;

 private:
  std::filesystem::path path_;
};

}  // namespace umov::cli
