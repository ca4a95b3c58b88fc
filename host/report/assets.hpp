// The parts of the page that are compiled into the program: markup, style, script and plotly.js.
#pragma once

#include <string_view>

namespace umov::report {

/// Views of static data, valid for the life of the program.
struct Assets {
  std::string_view markup;          ///< page/page.html, with {{NAME}} slots
  std::string_view style;           ///< page/page.css
  std::string_view script;          ///< of a report: page/*.js in the order in which they must run
  std::string_view diagnosis;       ///< likewise of a scan's diagnosis
  std::string_view map_diagnosis;   ///< likewise of a luminance map's
  std::string_view plotly;          ///< plotly.js, minified at build time
  std::string_view plotly_licence;  ///< its licence notice
};

Assets assets();

}  // namespace umov::report
