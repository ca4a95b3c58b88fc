// Studies: questions of papers, asked of the program and its emulated instrument, answered as a
// page.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "host/cli/study/page.hpp"

namespace umov::study {

struct Options {
  std::filesystem::path folder;     ///< for the page and what is measured on the way
  std::uint64_t seed = 1;           ///< of the emulated instrument and the fits
  int threads = 0;                  ///< 0 = all cores
  std::vector<std::string> models;  ///< only these, where a study takes models; empty: its own
  std::string command;              ///< command line, told on the page
  /// Share of the work that is done, 0 … 1, and what is being done; may be empty.
  std::function<void(double, const std::string&)> progress;
  std::function<bool()> keep_going;  ///< false: stop; may be empty
};

struct Study {
  std::string_view name;
  std::string_view about;
  Page (*run)(const Options&);
  bool takes_models = false;
};

/// All studies, in the order of the list that `umov study` prints.
std::span<const Study> studies();

/// Throws umov::Error listing the names for an unknown one.
const Study& find_study(std::string_view name);

/// Thrown where `keep_going` says no.
struct Stopped {};

/// Tells how far a study is; throws Stopped.
void step(const Options& options, double share, const std::string& what);

}  // namespace umov::study
