// What a simulation was made from: its scene file and the files that it names.
#pragma once

#include <filesystem>
#include <string>

namespace umov::cli {

/// SHA-256 of a scene file; where strings in it name files that are there (spectra, tables, meshes),
/// of it and of them in the order of the scene. Throws umov::Error where one cannot be read.
std::string scene_digest(const std::filesystem::path& scene);

}  // namespace umov::cli
