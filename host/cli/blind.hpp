// Subcommands of `umov blind`, one file each.
#pragma once

#include "host/cli/command.hpp"

namespace umov::cli {

void add_blind_make(CLI::App& blind, const Common& common);
void add_blind_scan(CLI::App& blind, const Common& common);
/// `effects` and `check`.
void add_blind_inspection(CLI::App& blind, const Common& common);
void add_blind_run(CLI::App& blind, const Common& common);
void add_blind_score(CLI::App& blind, const Common& common);

}  // namespace umov::cli
