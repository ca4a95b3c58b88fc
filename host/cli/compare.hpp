// umov invert --compare: which model of the library foretells rows that it has not seen.
#pragma once

#include <string>
#include <vector>

#include "host/cli/command.hpp"
#include "host/cli/progress.hpp"
#include "host/formats/brdf_table.hpp"
#include "host/invert/invert.hpp"

namespace umov::cli {

struct CompareArguments {
  std::string input;
  std::string output;             ///< of the winner's fit; "x.json" gives x.compare.json
  std::string models;             ///< "all", or names separated by commas
  std::vector<std::string> rows;  ///< conditions that selected the training rows, for the file
};

/// `training` is the table with only the rows to fit marked as used; null: every fifth row is held
/// out. Prints the ranking, writes comparison and the winner's fit.
void compare_command(const CompareArguments& arguments, const formats::BrdfTable& table,
                     const formats::BrdfTable* training, const invert::Options& options,
                     const Common& common, Progress& progress);

}  // namespace umov::cli
