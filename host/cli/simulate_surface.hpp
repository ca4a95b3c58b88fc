// umov simulate surface.
#pragma once

#include "host/cli/command.hpp"

namespace umov::cli {

/// Adds the subcommand to `umov simulate`.
void add_simulate_surface(CLI::App& simulate, const Common& common);

}  // namespace umov::cli
