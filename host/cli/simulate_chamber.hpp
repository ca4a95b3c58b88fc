// umov simulate chamber.
#pragma once

#include "host/cli/command.hpp"

namespace umov::cli {

void add_simulate_chamber_command(CLI::App& simulate, const Common& common);

}  // namespace umov::cli
