// umov simulate: what described things do to light, by ray tracing.
#include <CLI/CLI.hpp>

#include "host/cli/command.hpp"
#include "host/cli/simulate_chamber.hpp"
#include "host/cli/simulate_surface.hpp"

namespace umov::cli {

void add_simulate_command(CLI::App& root, const Common& common) {
  auto* simulate =
      root.add_subcommand("simulate", "what described things do to light, by ray tracing");
  simulate->require_subcommand(1);
  simulate->fallthrough();
  add_simulate_surface(*simulate, common);
  add_simulate_chamber_command(*simulate, common);
}

}  // namespace umov::cli
