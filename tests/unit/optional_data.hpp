// Measurements that are not shipped: tests that need them look for them here.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>

namespace umov::testing {

/// `inside` the folder that UMOV_DATA names; nullopt where the variable or the file is not there.
inline std::optional<std::filesystem::path> optional_data(const std::string& inside) {
  const char* folder = std::getenv("UMOV_DATA");
  if (folder == nullptr || !std::filesystem::exists(std::filesystem::path(folder) / inside))
    return std::nullopt;
  return std::filesystem::path(folder) / inside;
}

}  // namespace umov::testing
