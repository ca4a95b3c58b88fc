#include "host/report/report.hpp"

#include <array>
#include <string_view>
#include <utility>

#include "host/errors/error.hpp"
#include "host/formats/atomic_file.hpp"
#include "host/formats/markup.hpp"
#include "host/report/assets.hpp"
#include "host/report/inputs.hpp"

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

std::string title_of(const std::vector<Sample>& samples, const Options& options) {
  if (!options.title.empty()) return options.title;
  std::string names;
  for (const Sample& sample : samples) names += (names.empty() ? "" : ", ") + sample.name;
  return names;
}

}  // namespace

std::string page(const std::vector<Sample>& samples, const Options& options) {
  const Assets parts = assets();
  const std::string data = page_data(samples, options);
  const std::string title = formats::escaped_markup(title_of(samples, options));
  const std::string program = formats::escaped_markup(options.program);
  return filled(parts.markup, {{"PROGRAM", program},
                               {"TITLE", title},
                               {"STYLE", parts.style},
                               {"DATA", data},
                               {"PLOTLY_LICENCE", parts.plotly_licence},
                               {"PLOTLY", parts.plotly},
                               {"SCRIPT", parts.script}});
}

Summary write_report(std::span<const std::filesystem::path> files,
                     const std::filesystem::path& output, const Options& options) {
  if (files.empty())
    throw Error("no file was given to report on",
                "name scan.h5, cal.h5, brdf.h5 or fit.json files");
  std::vector<Input> inputs;
  for (const auto& file : files) inputs.push_back(read_input(file));
  const std::vector<Sample> samples = group(std::move(inputs));
  const std::string text = page(samples, options);
  formats::replace_file(output, text);
  Summary summary{samples.size(), text.size(), {}};
  for (const Sample& sample : samples)
    for (const std::string& warning : sample.warnings)
      summary.warnings.push_back(sample.name + ": " + warning);
  return summary;
}

}  // namespace umov::report
