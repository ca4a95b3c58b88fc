// Telling what an HDF5 file of this program holds.
#pragma once

#include <filesystem>

namespace umov::formats {

enum class H5Kind { scan, brdf, other };

/// By the root attribute `format`. Throws umov::Error for a file that is no HDF5 or is damaged.
H5Kind h5_kind(const std::filesystem::path& path);

}  // namespace umov::formats
