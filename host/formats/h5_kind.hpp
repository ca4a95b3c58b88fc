// Telling what an HDF5 file of this program holds.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace umov::formats {

/// sim: a luminance map, an intensity distribution.
enum class H5Kind { scan, brdf, table, sim, other };

/// By the root attribute `format`. Throws umov::Error for a file that is no HDF5 or is damaged.
H5Kind h5_kind(const std::filesystem::path& path);
/// The same from the bytes of a file; `name` stands in errors.
H5Kind h5_kind(std::string_view bytes, const std::string& name);

}  // namespace umov::formats
