#include "host/cli/answer_folder.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <random>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/errors/error.hpp"
#include "host/formats/atomic_file.hpp"
#include "host/formats/sha256.hpp"

namespace umov::cli {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* format_name = "umov blind answers 1";

/// Gives a finished file its name unless that is taken: never half a record, never two.
void place_record(const fs::path& path, const std::string& text) {
  // Processes of other machines may have the same number.
  const fs::path own = fmt::format("{}.{}.{:08x}", path.string(), getpid(), std::random_device{}());
  formats::replace_file(own, text);
  const int done = link(own.c_str(), path.c_str());
  const int why = errno;
  fs::remove(own);
  if (done != 0 && why != EEXIST) {
    throw Error({path.string()}, std::string("cannot be written: ") + std::strerror(why),
                "check space and permissions of the folder");
  }
}

bool any_answer(const fs::path& folder) {
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.is_directory() && fs::exists(entry.path() / answer_name)) return true;
  return false;
}

}  // namespace

std::vector<std::string> cases_in(const fs::path& set) {
  if (!fs::is_directory(set))
    throw Error({set.string()}, "is no folder", "name a set that `umov blind make` wrote");
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(set))
    if (entry.is_directory() && fs::exists(entry.path() / "scan.csv"))
      names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  if (names.empty())
    throw Error({set.string()}, "has no case_NNNN/scan.csv",
                "name a set that `umov blind make` wrote");
  return names;
}

std::string run_record(const std::string& version, const std::string& commit,
                       const std::string& options) {
  const Json record = {{"format", format_name},
                       {"program",
                        {{"version", version},
                         {"commit", commit},
                         {"sha256", formats::sha256_of_file("/proc/self/exe")}}},
                       {"options", Json::parse(options)}};
  return record.dump(1) + "\n";
}

void require_same_run(const fs::path& folder, const std::string& record) {
  fs::create_directories(folder);
  const fs::path path = folder / run_name;
  if (!fs::exists(path)) {
    if (any_answer(folder)) {
      throw Error({folder.string()}, "holds answers of an unknown program",
                  "name another folder with --answers");
    }
    place_record(path, record);
  }
  const Json here = Json::parse(formats::read_whole_file(path), nullptr, false);
  const Json wanted = Json::parse(record);
  if (here.is_discarded() || here.value("format", "") != format_name)
    throw Error({path.string()}, "is no record of a run", "name another folder with --answers");
  if (here.at("program").at("sha256") != wanted.at("program").at("sha256")) {
    throw Error({path.string()}, "these answers were given by another build of the program",
                "name another folder with --answers, or go on with the program that began");
  }
  if (here.at("options") != wanted.at("options")) {
    throw Error({path.string()},
                "these answers were given with other options: " + here.at("options").dump(),
                "repeat those, or name another folder with --answers");
  }
}

bool answered(const fs::path& folder, const std::string& name) {
  return fs::exists(folder / name / answer_name);
}

}  // namespace umov::cli
