// Where a command may write: never over its input, over other files only with --force.
#pragma once

#include <string>

namespace umov::cli {

/// Throws umov::Error where `output` is the same file as `input`, or exists and `force` is not set.
void require_new_output(const std::string& input, const std::string& output, bool force);

}  // namespace umov::cli
