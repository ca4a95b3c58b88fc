// umov device config: settings of the axes and of the lock-in, shown, changed, kept over restarts.
#pragma once

#include "host/cli/command.hpp"

namespace umov::cli {

/// Adds `config` with its subcommands get, set, save and defaults below `device`.
void add_device_config_command(CLI::App& device, const Common& common);

}  // namespace umov::cli
