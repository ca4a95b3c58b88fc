// A look at a TOML text before the parser gets it.
#pragma once

#include <string>
#include <string_view>

namespace umov {

/// Refuses what toml++ 3.3 takes for granted instead of checking: control characters, letters
/// outside ASCII where TOML has none (outside of texts and comments), texts that start or end in
/// the middle of a word, brackets that do not match, and table headers that do not start with a key
/// (`[=]`). On these it aborts in debug builds and is undefined in others; the same holds for a
/// letter outside ASCII that comes first after a line continued with `\`, which TOML allows and
/// this refuses. Throws umov::Error with line and column.
void refuse_unparsable(std::string_view text, const std::string& file);

}  // namespace umov
