// umov blind: cases with withheld effects, to test a diagnosis that does not know the answer.
#include "host/cli/blind.hpp"

#include <CLI/CLI.hpp>

namespace umov::cli {

void add_blind_command(CLI::App& root, const Common& common) {
  auto* command = root.add_subcommand(
      "blind",
      "Scans whose effects are withheld: made from an emulated instrument, their truth sealed");
  command->require_subcommand(1);
  command->fallthrough();
  add_blind_make(*command, common);
  add_blind_scan(*command, common);
  add_blind_run(*command, common);
  add_blind_score(*command, common);
  add_blind_inspection(*command, common);
}

}  // namespace umov::cli
