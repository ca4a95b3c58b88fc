// A report: one HTML page that holds its data, its figures and the library that draws them.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "host/report/sample.hpp"

namespace umov::report {

struct Options {
  std::string title;    ///< empty: made from the samples' names
  std::string program;  ///< "umov 0.1.0"
  std::string command;  ///< command line, shown at the foot; may be empty
  std::string created;  ///< UTC, ISO 8601; empty: now
};

/// The page's data as JSON text, "<" escaped so that it can stand inside a script element:
/// everything that is drawn or printed, numbers rounded to what a figure can show. The layout is
/// that which page/main.js reads. Throws umov::Error where a fit names an unknown model.
std::string page_data(const std::vector<Sample>& samples, const Options& options);

/// The whole page, UTF-8. Loads nothing from anywhere.
std::string page(const std::vector<Sample>& samples, const Options& options);

struct Summary {
  std::size_t samples = 0;
  std::size_t bytes = 0;
  std::vector<std::string> warnings;
};

/// Reads the files (any kinds, any order), groups them, and writes the page. An existing page is
/// replaced only when the new one is complete. Throws umov::Error.
Summary write_report(std::span<const std::filesystem::path> files,
                     const std::filesystem::path& output, const Options& options);

}  // namespace umov::report
