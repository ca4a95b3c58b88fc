// A folder of its own for each test, removed at the end, and the optional data folder.
#pragma once

#include <gtest/gtest.h>

#include <unistd.h>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>

namespace umov::formats::testing {

class ScratchFolder {
 public:
  ScratchFolder() {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    std::string name = std::string("umov_") + info->test_suite_name() + "_" + info->name() + "_" +
                       std::to_string(::getpid());
    for (char& c : name)
      if (c == '/') c = '_';
    path_ = std::filesystem::temp_directory_path() / name;
    std::filesystem::create_directories(path_);
  }
  ~ScratchFolder() { std::filesystem::remove_all(path_); }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// $UMOV_DATA, or shared/data beside the source tree; nullopt where neither exists.
inline std::optional<std::filesystem::path> optional_data(const std::string& inside) {
  const char* named = std::getenv("UMOV_DATA");
  const std::filesystem::path folder =
      named != nullptr ? std::filesystem::path(named)
                       : std::filesystem::path(UMOV_SOURCE_DIR) / ".." / "shared" / "data";
  if (!std::filesystem::exists(folder / inside)) return std::nullopt;
  return folder / inside;
}

}  // namespace umov::formats::testing
