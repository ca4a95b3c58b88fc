// umov device selftest: whether a controller and what hangs on it work.
#pragma once

#include "host/cli/command.hpp"

namespace umov::cli {

/// Adds `selftest` below `device`.
void add_device_selftest_command(CLI::App& device, const Common& common);

}  // namespace umov::cli
