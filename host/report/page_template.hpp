// The template of a page and what goes into its slots.
#pragma once

#include <string>
#include <string_view>

namespace umov::report {

/// What differs from page to page. Texts are escaped here; `data` must be embeddable() already.
struct PageSlots {
  std::string program, title, data;
  std::string_view script;  ///< of Assets
};

/// The whole page, UTF-8. Loads nothing from anywhere.
std::string filled_page(const PageSlots& slots);

/// JSON text that can stand inside a script element: "<" is escaped.
std::string embeddable(std::string_view json);

}  // namespace umov::report
