// TOML files with the project's errors.
#pragma once

#include <string>
#include <string_view>

#include <toml++/toml.h>

namespace umov {

/// The table of a TOML text. `file` names it in errors.
/// Throws umov::Error with line and column, and `remedy`, where the text is not TOML.
toml::table parse_toml(std::string_view text, const std::string& file, const std::string& remedy);

}  // namespace umov
