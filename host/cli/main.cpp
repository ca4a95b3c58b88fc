// The program `umov`: parses the command line, runs one command, turns errors into one message.
#include <csignal>
#include <cstdio>
#include <exception>
#include <string>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "host/cli/command.hpp"
#include "host/cli/interrupt.hpp"
#include "host/errors/error.hpp"

namespace {

/// As a shell reads it back: in single quotes where it holds more than plain characters.
std::string quoted(const std::string& word) {
  constexpr const char* plain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+=:,./@%";
  if (!word.empty() && word.find_first_not_of(plain) == std::string::npos) return word;
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

std::string joined(int argc, char** argv) {
  std::string text = "umov";
  for (int i = 1; i < argc; ++i) text += " " + quoted(argv[i]);
  return text;
}

}  // namespace

int main(int argc, char** argv) {
  using namespace umov::cli;
  CLI::App app{
      "Umov: polarised multispectral gonio-reflectometry.\n"
      "Scan a sample, calibrate, reduce to a BRDF, invert to a model, report.",
      "umov"};
  app.require_subcommand(1);
  app.fallthrough();
  app.set_version_flag("--version", UMOV_VERSION);

  Common common;
  common.command_line = joined(argc, argv);
  app.add_flag("--json", common.json, "machine-readable text on stdout");
  app.add_flag("--quiet", common.quiet, "no progress, no notes");
  app.add_option("--seed", common.seed, "seed of everything random")->capture_default_str();
  app.add_option("--threads", common.threads, "threads to use, 0 = all cores")
      ->capture_default_str();

  add_emulator_command(app, common);
  add_scan_command(app, common);
  add_calibrate_command(app, common);
  add_reduce_command(app, common);
  add_invert_command(app, common);
  add_diagnose_command(app, common);
  add_model_command(app, common);
  add_report_command(app, common);
  add_import_command(app, common);
  add_export_command(app, common);
  add_device_command(app, common);
  add_study_command(app, common);
  add_blind_command(app, common);
  add_simulate_command(app, common);

  try {
    app.parse(argc, argv);
    return 0;
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const Interrupted& interrupted) {
    fmt::print(stderr, "umov: {}\n", interrupted.what());
    return 130;
  } catch (const umov::Error& error) {
    fmt::print(stderr, "umov: {}\n", error.what());
    return 1;
  } catch (const std::exception& error) {
    fmt::print(stderr, "umov: internal error: {}\n", error.what());
    return 1;
  }
}
