#include "host/report/page_template.hpp"

#include <utility>
#include <vector>

#include "host/formats/markup.hpp"
#include "host/report/assets.hpp"

namespace umov::report {

namespace {

/// Fills the slots {{NAME}} of the template in one pass, so that what is put in is never searched.
std::string filled(std::string_view markup,
                   const std::vector<std::pair<std::string_view, std::string_view>>& slots) {
  std::string out;
  std::size_t at = 0;
  while (true) {
    const std::size_t open = markup.find("{{", at);
    if (open == std::string_view::npos) break;
    const std::size_t close = markup.find("}}", open);
    const std::string_view name = markup.substr(open + 2, close - open - 2);
    out += markup.substr(at, open - at);
    for (const auto& [slot, text] : slots)
      if (slot == name) out += text;
    at = close + 2;
  }
  out += markup.substr(at);
  return out;
}

}  // namespace

std::string filled_page(const PageSlots& slots) {
  const Assets parts = assets();
  const std::string program = formats::escaped_markup(slots.program);
  const std::string title = formats::escaped_markup(slots.title);
  return filled(parts.markup, {{"PROGRAM", program},
                               {"TITLE", title},
                               {"STYLE", parts.style},
                               {"DATA", slots.data},
                               {"PLOTLY_LICENCE", parts.plotly_licence},
                               {"PLOTLY", parts.plotly},
                               {"SCRIPT", slots.script}});
}

std::string embeddable(std::string_view json) {
  // "</script>" and "<!--" would end or derail the element that holds the text.
  std::string safe;
  safe.reserve(json.size());
  for (const char c : json) {
    if (c == '<')
      safe += "\\u003c";
    else
      safe += c;
  }
  return safe;
}

}  // namespace umov::report
