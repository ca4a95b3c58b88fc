// The index tables that the build compiles in, as text.
#pragma once

#include <span>
#include <string_view>

namespace umov::optics {

struct EmbeddedIndex {
  std::string_view name;  ///< file name without ".yml"
  std::string_view text;  ///< the file
};

/// Sorted by name.
std::span<const EmbeddedIndex> embedded_indices();

}  // namespace umov::optics
