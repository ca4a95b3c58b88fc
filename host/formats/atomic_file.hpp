// Writing a file so that a failure leaves the older one as it was: temporary neighbour, then
// rename.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

namespace umov::formats {

/// Owns a temporary path beside `target`; removes it unless `commit` has renamed it.
class ReplacedFile {
 public:
  explicit ReplacedFile(std::filesystem::path target);
  ReplacedFile(const ReplacedFile&) = delete;
  ReplacedFile& operator=(const ReplacedFile&) = delete;
  ~ReplacedFile();

  /// Where to write. Same folder as the target, so that the rename is atomic.
  const std::filesystem::path& temporary() const { return temporary_; }
  /// Syncs the temporary file to the medium and puts it in the target's place. Throws umov::Error.
  void commit();

 private:
  std::filesystem::path target_;
  std::filesystem::path temporary_;
  bool committed_ = false;
};

/// Writes `bytes` to `target` that way. Throws umov::Error.
void replace_file(const std::filesystem::path& target, std::string_view bytes);

/// More than this is not read into memory.
inline constexpr std::size_t largest_file_bytes = std::size_t{2} << 30;

/// Throws umov::Error where `bytes` is more than `most`.
void require_readable_size(std::size_t bytes, const std::string& name,
                           std::size_t most = largest_file_bytes);

/// Whole content of a file or pipe (/dev/stdin, a shell's <(…)). Throws umov::Error where it is
/// missing, a folder, a device, larger than `most` bytes or unreadable.
std::string read_whole_file(const std::filesystem::path& path,
                            std::size_t most = largest_file_bytes);

/// fsync of a folder, so that a new or renamed entry survives a power cut.
void sync_folder_of(const std::filesystem::path& path);

}  // namespace umov::formats
