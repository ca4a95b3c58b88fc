#include "host/report/report.hpp"

#include "host/errors/error.hpp"
#include "host/formats/atomic_file.hpp"
#include "host/report/assets.hpp"
#include "host/report/inputs.hpp"
#include "host/report/page_template.hpp"

namespace umov::report {

namespace {

std::string title_of(const std::vector<Sample>& samples, const Options& options) {
  if (!options.title.empty()) return options.title;
  std::string names;
  for (const Sample& sample : samples) names += (names.empty() ? "" : ", ") + sample.name;
  return names;
}

}  // namespace

std::string page(const std::vector<Sample>& samples, const Options& options) {
  return filled_page(
      {options.program, title_of(samples, options), page_data(samples, options), assets().script});
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
