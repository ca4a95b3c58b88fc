// A look at a TOML text before the parser gets it.
#pragma once

#include <string>
#include <string_view>

namespace umov::formats {

/// Refuses what toml++ 3.3 takes for granted instead of checking: control characters, letters
/// outside ASCII where TOML has none (outside of texts and comments), brackets that do not match,
/// and table headers that do not start with a key (`[=]`). On these it aborts in debug builds and
/// is undefined in others. Throws umov::Error with line and column.
void refuse_unparsable(std::string_view text, const std::string& file);

}  // namespace umov::formats
