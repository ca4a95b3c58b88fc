// umov device flash, sign, key: programs for controllers.
#pragma once

#include "host/cli/command.hpp"

namespace umov::cli {

/// Adds the subcommands below `device`.
void add_device_flash_commands(CLI::App& device, const Common& common);

}  // namespace umov::cli
