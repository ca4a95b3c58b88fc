// The sample files that the build compiles in, as text.
#pragma once

#include <span>
#include <string_view>

namespace umov::plant {

struct EmbeddedSample {
  std::string_view name;  ///< file name without ".toml"
  std::string_view text;  ///< the file
};

/// Sorted by name.
std::span<const EmbeddedSample> embedded_samples();

}  // namespace umov::plant
