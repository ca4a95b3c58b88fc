// Text inside XML and HTML.
#pragma once

#include <string>
#include <string_view>

namespace umov::formats {

/// Stands for the same characters as content of an element and inside a quoted attribute: &, <, >,
/// " and ' become entities.
std::string escaped_markup(std::string_view text);

}  // namespace umov::formats
