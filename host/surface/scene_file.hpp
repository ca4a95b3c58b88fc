// Scene files: a rough, dirty or wet surface in TOML. Keys: host/surface/README.md.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "host/trace/scene.hpp"

namespace umov::surface {

/// One [[particles]] of a file, as it was laid.
struct Layer {
  std::string kind;
  std::size_t count;
  double coverage;  ///< area seen from above over that of the ground
};

struct Surface {
  trace::Scene scene;  ///< lengths in µm
  std::vector<Layer> layers;
};

/// `file` names the text in errors. `seed` lays particles and makes rough ground. Throws
/// umov::Error, with the line where there is one, for what is unknown, missing, out of range or
/// cannot be laid.
Surface surface_from_toml(std::string_view text, const std::string& file, std::uint64_t seed);

/// The same from a file.
Surface read_surface(const std::filesystem::path& path, std::uint64_t seed);

}  // namespace umov::surface
