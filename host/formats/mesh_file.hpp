// Triangle meshes from the files of modelling programs: Wavefront OBJ, STL (text and binary).
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace umov::formats {

/// The front of a face is where its vertices run counter-clockwise.
struct MeshFile {
  std::vector<std::array<float, 3>> vertices;
  std::vector<std::array<std::uint32_t, 3>> faces;

  /// Edges that do not belong to exactly two faces that run along it in opposite directions; 0 for
  /// a closed mesh with all fronts on one side. Vertices at the same place count as one.
  std::size_t open_edges() const;
};

/// By content. OBJ: `v` and `f` lines, polygons as fans, negative numbers; all else is passed over.
/// Faces without an area are left out. Throws umov::Error with line or byte for a damaged file.
MeshFile read_mesh(const std::filesystem::path& path);
MeshFile parse_mesh(std::string_view bytes, const std::string& file);

}  // namespace umov::formats
