// The layers of the project, enforced: reads every #include of every source file and refuses an
// arrow that the architecture does not have.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace {

namespace fs = std::filesystem;

// Folder -> folders it may include (itself always). A file belongs to the longest folder that
// is a prefix of its path.
const std::map<std::string, std::set<std::string>> allowed = {
    {"protocol", {}},
    {"protocol/tools", {"protocol"}},
    {"firmware", {"protocol"}},
    {"boards/native", {"protocol", "firmware"}},
    {"boards/stm32f407", {"protocol", "firmware"}},
    {"host/errors", {}},
    {"host/net", {"host/errors"}},
    {"host/parallel", {}},
    {"host/parallel/ranks", {"host/errors", "host/parallel"}},
    {"host/toml", {"host/errors"}},
    {"host/optics", {"host/errors"}},
    {"host/brdf", {"host/errors", "host/optics"}},
    {"host/trace", {"host/errors", "host/parallel", "host/optics", "host/brdf"}},
    {"host/surface",
     {"host/errors", "host/toml", "host/optics", "host/brdf", "host/formats", "host/trace"}},
    {"host/chamber",
     {"host/errors", "host/parallel", "host/toml", "host/optics", "host/brdf", "host/formats",
      "host/trace"}},
    {"host/formats", {"host/errors", "host/optics", "host/brdf"}},
    {"host/instrument", {"host/errors", "host/net", "protocol"}},
    {"host/scan",
     {"host/errors", "host/toml", "host/optics", "host/formats", "host/instrument", "protocol"}},
    {"host/calibrate",
     {"host/errors", "host/parallel", "host/toml", "host/optics", "host/brdf", "host/formats"}},
    {"host/invert", {"host/errors", "host/parallel", "host/optics", "host/brdf", "host/formats"}},
    // The engine of the diagnosis knows no forward model; its adapters do.
    {"host/gap/engine", {"host/errors", "host/parallel"}},
    {"host/gap/answer", {"host/errors", "host/gap/engine"}},
    {"host/gap/pointing", {"host/errors", "host/formats", "host/gap/engine"}},
    {"host/gap/surface",
     {"host/errors", "host/optics", "host/formats", "host/trace", "host/surface",
      "host/gap/engine"}},
    {"host/gap/chamber", {"host/errors", "host/optics", "host/chamber", "host/gap/engine"}},
    {"host/gap/scan",
     {"host/errors", "host/parallel", "host/toml", "host/optics", "host/brdf", "host/formats",
      "host/calibrate", "host/invert", "host/gap/engine"}},
    // Diagnoses cases and scores answers; how cases are made it cannot know.
    {"host/gap/benchmark",
     {"host/parallel", "host/errors", "host/formats", "host/gap/engine", "host/gap/scan",
      "host/gap/answer"}},
    // A page shows what files say and what a diagnosis found; it diagnoses nothing itself.
    {"host/report",
     {"host/errors", "host/optics", "host/brdf", "host/formats", "host/calibrate", "host/invert",
      "host/gap/engine", "host/gap/scan", "host/gap/chamber", "host/gap/answer"}},
    // The plant's world: of the host plain optics (and errors and TOML) only, so that a diagnosis
    // is never tested on its own model run forwards.
    {"hil/plant", {"host/optics", "host/errors", "host/toml"}},
    // The chip knows nothing of what runs on it; its wiring reads the board's description.
    {"hil/mcu", {"host/errors"}},
    {"hil/mcu/gdb", {"hil/mcu", "host/net", "host/errors"}},
    {"hil/mcu/board", {"hil/mcu", "hil/usbip", "host/errors", "boards/stm32f407"}},
    // Withheld cases are made by the plant and written as Scan CSV; see also the test on its
    // formats.
    {"hil/blind", {"hil/plant", "host/optics", "host/errors", "host/toml", "host/formats"}},
    // A virtual cable between a kernel and anything with a USB connector; it knows no instrument.
    {"hil/usbip", {"host/errors", "host/net", "firmware"}},
    {"host/cli/emulator",
     {"host/errors", "host/optics", "host/instrument", "boards/native", "firmware", "hil/plant",
      "hil/usbip", "protocol"}},
    {"host/cli/emulator/mcu",
     {"host/cli/emulator", "host/instrument", "hil/mcu", "hil/mcu/board", "hil/mcu/gdb",
      "hil/plant", "hil/usbip"}},
    {"host/cli/study", {"host/gap/answer", "host/gap/benchmark", "host/errors",
                        "host/parallel",   "host/optics",        "host/brdf",
                        "host/formats",    "host/instrument",    "host/scan",
                        "host/calibrate",  "host/invert",        "host/gap/engine",
                        "host/gap/scan",   "host/gap/pointing",  "host/gap/surface",
                        "host/report",     "host/cli/emulator",  "host/trace",
                        "host/surface",    "host/chamber",       "host/gap/chamber",
                        "protocol"}},
    {"host/cli",
     {"host/errors",
      "host/optics",
      "host/trace",
      "host/surface",
      "host/chamber",
      "host/brdf",
      "host/formats",
      "host/instrument",
      "host/scan",
      "hil/plant",
      "hil/blind",
      "host/calibrate",
      "host/invert",
      "host/gap/engine",
      "host/gap/scan",
      "host/gap/answer",
      "host/gap/benchmark",
      "host/parallel/ranks",
      "host/report",
      "host/cli/emulator",
      "host/cli/emulator/mcu",
      "host/gap/surface",
      "host/gap/chamber",
      "host/cli/study",
      "host/toml",
      "protocol"}},
};

// What freestanding code may take from the standard library.
const std::set<std::string> freestanding_headers = {
    "algorithm", "array",       "atomic",     "bit",         "climits", "concepts", "cstddef",
    "cstdint",   "cstring",     "functional", "iterator",    "limits",  "new",      "optional",
    "span",      "string_view", "tuple",      "type_traits", "utility", "compare",  "version"};

struct Include {
  std::string file;
  int line;
  std::string target;
  bool quoted;
};

std::string folder_of(const std::string& path) {
  std::string best;
  for (const auto& [folder, unused] : allowed) {
    if (path.starts_with(folder + "/") && folder.size() > best.size()) best = folder;
  }
  return best;
}

std::vector<Include> includes_below(const fs::path& root, const std::string& top) {
  static const std::regex pattern(R"re(^\s*#\s*include\s*([<"])([^>"]+)[>"])re");
  std::vector<Include> found;
  if (!fs::exists(root / top)) return found;
  for (const auto& entry : fs::recursive_directory_iterator(root / top)) {
    const auto extension = entry.path().extension();
    if (extension != ".cpp" && extension != ".hpp" && extension != ".h" && extension != ".c")
      continue;
    std::ifstream stream(entry.path());
    std::string text;
    for (int line = 1; std::getline(stream, text); ++line) {
      std::smatch match;
      if (std::regex_search(text, match, pattern)) {
        found.push_back({fs::relative(entry.path(), root).generic_string(), line, match[2].str(),
                         match[1].str() == "\""});
      }
    }
  }
  return found;
}

// The complaint about one include, empty when it is fine.
std::string violation(const Include& include) {
  const std::string from = folder_of(include.file);
  const std::string where = include.file + ":" + std::to_string(include.line) + ": ";
  if (from.empty()) return where + "belongs to no declared layer";
  if (!include.quoted) {
    const bool freestanding = (from == "protocol" || from == "firmware");
    if (freestanding && !freestanding_headers.contains(include.target)) {
      return where + "<" + include.target + "> is not freestanding";
    }
    return {};
  }
  const std::string to = folder_of(include.target);
  if (to.empty())
    return where + "\"" + include.target + "\" is not written from the repository's root";
  if (to == from || allowed.at(from).contains(to)) return {};
  return where + from + " must not include " + to + " (\"" + include.target + "\")";
}

TEST(Layers, every_include_follows_an_arrow_of_the_architecture) {
  const fs::path root = UMOV_SOURCE_DIR;
  std::size_t seen = 0;
  for (const auto* top : {"protocol", "firmware", "boards", "hil", "host"}) {
    for (const auto& include : includes_below(root, top)) {
      ++seen;
      EXPECT_EQ(violation(include), "");
    }
  }
  EXPECT_GT(seen, 100u) << "the sources were not found below " << root;
}

TEST(Layers, a_plant_that_uses_the_host_models_would_be_caught) {
  EXPECT_NE(violation({"hil/plant/sample.cpp", 3, "host/brdf/model.hpp", true}), "");
  EXPECT_NE(violation({"hil/plant/sample.cpp", 3, "host/formats/scan_table.hpp", true}), "");
  EXPECT_EQ(violation({"hil/plant/sample.cpp", 3, "host/optics/fresnel.hpp", true}), "");
}

TEST(Layers, withheld_cases_know_of_the_formats_only_scans_and_checksums) {
  const std::set<std::string> permitted = {
      "host/formats/scan_csv.hpp", "host/formats/scan_table.hpp", "host/formats/sha256.hpp"};
  std::size_t seen = 0;
  for (const auto& include : includes_below(UMOV_SOURCE_DIR, "hil/blind")) {
    if (folder_of(include.target) != "host/formats") continue;
    ++seen;
    EXPECT_TRUE(permitted.contains(include.target))
        << include.file << ":" << include.line << " includes " << include.target;
  }
  EXPECT_GT(seen, 0u);
  EXPECT_NE(violation({"hil/blind/change.cpp", 3, "host/gap/scan/chain.hpp", true}), "");
  EXPECT_NE(violation({"hil/blind/material.cpp", 3, "host/brdf/model.hpp", true}), "");
}

TEST(Layers, upward_hidden_and_hosted_includes_would_be_caught) {
  EXPECT_NE(violation({"host/optics/fresnel.hpp", 1, "host/brdf/model.hpp", true}), "");
  EXPECT_NE(violation({"firmware/core/motion/profile.hpp", 1, "vector", false}), "");
  EXPECT_NE(violation({"firmware/core/motion/profile.hpp", 1, "boards/native/world.hpp", true}),
            "");
  EXPECT_NE(violation({"host/scan/runner.cpp", 1, "runner.hpp", true}), "");
  EXPECT_EQ(violation({"host/cli/main.cpp", 1, "vector", false}), "");
}

}  // namespace
