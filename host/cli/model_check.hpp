// umov model check.
#pragma once

#include "host/cli/command.hpp"

namespace umov::cli {

/// Adds `check` to the command `model`.
void add_model_check(CLI::App& model, const Common& common);

}  // namespace umov::cli
