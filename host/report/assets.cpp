// The files of page/ and the minified plotly.js, put into the program by the assembler. `.incbin`
// costs neither compile time nor memory, where a string literal of this size would cost both.
#include "host/report/assets.hpp"

#include <initializer_list>
#include <string>

#define UMOV_EMBED(symbol, file)               \
  asm(".pushsection .rodata\n"                 \
      ".global umov_asset_" #symbol            \
      "\n"                                     \
      ".global umov_asset_" #symbol            \
      "_end\n"                                 \
      ".balign 16\n"                           \
      "umov_asset_" #symbol                    \
      ":\n"                                    \
      ".incbin \"" file                        \
      "\"\n"                                   \
      "umov_asset_" #symbol                    \
      "_end:\n"                                \
      ".byte 0\n"                              \
      ".popsection\n");                        \
  extern "C" const char umov_asset_##symbol[]; \
  extern "C" const char umov_asset_##symbol##_end[];

UMOV_EMBED(markup, UMOV_PAGE_FOLDER "/page.html")
UMOV_EMBED(style, UMOV_PAGE_FOLDER "/page.css")
UMOV_EMBED(theme, UMOV_PAGE_FOLDER "/theme.js")
UMOV_EMBED(dom, UMOV_PAGE_FOLDER "/dom.js")
UMOV_EMBED(figure, UMOV_PAGE_FOLDER "/figure.js")
UMOV_EMBED(curves, UMOV_PAGE_FOLDER "/curves.js")
UMOV_EMBED(residuals, UMOV_PAGE_FOLDER "/residuals.js")
UMOV_EMBED(lobe, UMOV_PAGE_FOLDER "/lobe.js")
UMOV_EMBED(prediction, UMOV_PAGE_FOLDER "/prediction.js")
UMOV_EMBED(fit, UMOV_PAGE_FOLDER "/fit.js")
UMOV_EMBED(scan, UMOV_PAGE_FOLDER "/scan.js")
UMOV_EMBED(frame, UMOV_PAGE_FOLDER "/frame.js")
UMOV_EMBED(main, UMOV_PAGE_FOLDER "/main.js")
UMOV_EMBED(diagnosis_maps, UMOV_PAGE_FOLDER "/diagnosis_maps.js")
UMOV_EMBED(diagnosis_causes, UMOV_PAGE_FOLDER "/diagnosis_causes.js")
UMOV_EMBED(diagnosis_parts, UMOV_PAGE_FOLDER "/diagnosis_parts.js")
UMOV_EMBED(diagnosis, UMOV_PAGE_FOLDER "/diagnosis.js")
UMOV_EMBED(map_diagnosis, UMOV_PAGE_FOLDER "/map_diagnosis.js")
UMOV_EMBED(licence, UMOV_PAGE_FOLDER "/plotly_licence.txt")
UMOV_EMBED(plotly, UMOV_PLOTLY_MIN)

namespace umov::report {

namespace {

std::string_view between(const char* begin, const char* end) {
  return {begin, static_cast<std::size_t>(end - begin)};
}

#define UMOV_ASSET(symbol) between(umov_asset_##symbol, umov_asset_##symbol##_end)

/// One script: the parts share one scope and are loaded in the order in which they use each other.
std::string joined(std::initializer_list<std::string_view> parts) {
  std::string out;
  for (const std::string_view part : parts) {
    out += part;
    out += '\n';
  }
  return out;
}

const std::string& report_script() {
  static const std::string script =
      joined({UMOV_ASSET(theme), UMOV_ASSET(dom), UMOV_ASSET(figure), UMOV_ASSET(curves),
              UMOV_ASSET(residuals), UMOV_ASSET(lobe), UMOV_ASSET(prediction), UMOV_ASSET(fit),
              UMOV_ASSET(scan), UMOV_ASSET(frame), UMOV_ASSET(main)});
  return script;
}

const std::string& diagnosis_script() {
  static const std::string script =
      joined({UMOV_ASSET(theme), UMOV_ASSET(dom), UMOV_ASSET(figure), UMOV_ASSET(diagnosis_maps),
              UMOV_ASSET(diagnosis_causes), UMOV_ASSET(frame), UMOV_ASSET(diagnosis_parts),
              UMOV_ASSET(diagnosis)});
  return script;
}

const std::string& map_diagnosis_script() {
  static const std::string script =
      joined({UMOV_ASSET(theme), UMOV_ASSET(dom), UMOV_ASSET(figure), UMOV_ASSET(diagnosis_maps),
              UMOV_ASSET(diagnosis_causes), UMOV_ASSET(frame), UMOV_ASSET(diagnosis_parts),
              UMOV_ASSET(map_diagnosis)});
  return script;
}

}  // namespace

Assets assets() {
  return {UMOV_ASSET(markup),     UMOV_ASSET(style),  report_script(),    diagnosis_script(),
          map_diagnosis_script(), UMOV_ASSET(plotly), UMOV_ASSET(licence)};
}

}  // namespace umov::report
