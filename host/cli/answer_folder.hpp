// Answers to a set of cases on disk: one folder a case, and a record of what gave them.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace umov::cli {

inline constexpr const char* answer_name = "answer.json";
inline constexpr const char* followed_name = "answer_followed.json";
inline constexpr const char* rivals_name = "rivals.json";
inline constexpr const char* timing_name = "timing.json";
inline constexpr const char* run_name = "RUN.json";

/// Folders of `set` that hold a scan.csv, by name. Throws umov::Error where there are none.
std::vector<std::string> cases_in(const std::filesystem::path& set);

/// The record of a run: program (version, SHA-256 of the executable, commit as stated) and options.
/// `options` is the text of a JSON object.
std::string run_record(const std::string& version, const std::string& commit,
                       const std::string& options);

/// Writes the record into `folder` where there is none yet; of several processes that come at once
/// one does. Throws umov::Error where one of another program or of other options is there, or
/// answers without a record.
void require_same_run(const std::filesystem::path& folder, const std::string& record);

/// Is a case answered? Its answer is written last.
bool answered(const std::filesystem::path& folder, const std::string& name);

}  // namespace umov::cli
