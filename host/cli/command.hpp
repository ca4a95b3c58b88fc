// How subcommands hook into the program: one file a command, each with one `add_…` function.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

namespace CLI {
class App;
}

namespace umov::cli {

/// Options every command has. Filled by the root parser before a command runs.
struct Common {
  bool json = false;       ///< machine-readable text on stdout
  bool quiet = false;      ///< no progress, no notes
  std::uint64_t seed = 1;  ///< for everything random
  int threads = 0;         ///< 0 = all cores
  std::string command_line;
};

// Each adds one subcommand. Errors are thrown as umov::Error; the root prints them and exits
// with 1.
void add_emulator_command(CLI::App& root, const Common& common);
void add_scan_command(CLI::App& root, const Common& common);
void add_calibrate_command(CLI::App& root, const Common& common);
void add_reduce_command(CLI::App& root, const Common& common);
void add_invert_command(CLI::App& root, const Common& common);
void add_diagnose_command(CLI::App& root, const Common& common);
void add_model_command(CLI::App& root, const Common& common);
void add_report_command(CLI::App& root, const Common& common);
void add_import_command(CLI::App& root, const Common& common);
void add_export_command(CLI::App& root, const Common& common);
void add_device_command(CLI::App& root, const Common& common);
void add_study_command(CLI::App& root, const Common& common);
void add_blind_command(CLI::App& root, const Common& common);
void add_simulate_command(CLI::App& root, const Common& common);

}  // namespace umov::cli
